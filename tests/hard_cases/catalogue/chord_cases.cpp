// R, continued. The position of the root on the chord, of the chord in its cell, of the eye beside
// the cell, and of the isovalue among the values.
#include <array>

#include "tests/hard_cases/catalogue/cube_of_samples.h"

namespace rhoray::tests {
namespace {

Pack rising_along_x() {
  return grid_of<std::uint8_t>(cube, [](const Index3& at) { return static_cast<std::uint8_t>(at.x); });
}
Pack rising_along_x_in_double() {
  return grid_of<double>(cube, [](const Index3& at) { return static_cast<double>(at.x); });
}

Rays rays_in_planes(int axes_in_planes, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    Vec3 direction = direction_in_eighths(dice);
    Vec3 target =
        as_point({dice.below(64 * (edge - 1)), dice.below(64 * (edge - 1)), dice.below(64 * (edge - 1))}) / 64;
    const auto first = dice.below(3);
    for (int n = 0; n < axes_in_planes; ++n) {
      const int a = static_cast<int>((first + n) % 3);
      target[a] = std::round(target[a]);
      direction[a] = 0;
    }
    if (direction.length() > 0) rays.push_back(through(target, direction, 128));
  }
  return rays;
}

Rays rays_along_diagonals(std::size_t count, std::uint64_t seed) {
  constexpr std::array<double, 3> signs{1, -1, 0};
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const Vec3 direction{dice.one_of(signs), dice.one_of(signs), dice.one_of(signs)};
    if (direction.length2() < 2) continue;
    rays.push_back(through(as_point({dice.below(edge), dice.below(edge), dice.below(edge)}), direction, 20));
  }
  return rays;
}

/// Rays that pass lattice points at a small distance.
Rays rays_beside_corners(double least, double most, std::size_t count, std::uint64_t seed) {
  Rays rays = aimed_rays(size, 3, count, seed);
  Dice dice(seed);
  for (render::Ray& ray : rays) {
    const double distance = std::pow(10, dice.between(std::log10(least), std::log10(most)));
    ray.origin += distance * dice.direction();
  }
  return rays;
}

Rays rays_from_inside(std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) rays.push_back({.origin = dice.point({0, 0, 0}, size), .direction = dice.direction()});
  return rays;
}

HardCase root_on_a_face(const std::string& id, bool rising) {
  return {
      .id = id,
      .story = rising ? "The surface is a plane of samples, met from outside: the root is at the end of one cell "
                        "and at the start of the next, and one hit is due."
                      : "The same plane met from inside: now the side changes behind it.",
      .pack = rising_along_x(),
      .isovalues = {3, 7},
      .rays = only(all_kinds_of_rays(size, 500, 1), [=](const auto& ray) { return (ray.direction.x > 0) == rising; }),
      .naive = {"paper float", 50},
      .known = plane_in_box({1, 0, 0}, size)};
}

HardCase root_beside_a_face() {
  return {.id = "R14",
          .story =
              "The surface lies one unit of rounding beside a plane of samples: each of the two cells may find it "
              "in the other.",
          .pack = rising_along_x_in_double(),
          .isovalues = {std::nextafter(3.0, 0.0), std::nextafter(3.0, 9.0), std::nextafter(6.0, 0.0)},
          .rays = all_kinds_of_rays(size, 240, 1),
          .naive = {"paper float", 73},
          .known = plane_in_box({1, 0, 0}, size)};
}

HardCase nearly_parallel() {
  Rays rays;
  Dice dice(1);
  while (rays.size() < 300) {
    const double sign = dice.coin() ? 1 : -1;
    const Vec3 direction{dice.between(0.1, 1), dice.between(-0.1, 0.1), sign * dice.between(1e-7, 1e-6)};
    const Vec3 target{dice.between(8, 40), dice.between(8, 12), 3.5};
    rays.push_back(through(target, direction, dice.between(0, 5)));
  }
  return {.id = "R24",
          .story =
              "A plane met at an angle of a ten-millionth: what is off in the values is off ten million times as "
              "much in t.",
          .pack = grid_of<float>({48, 20, 8}, [](const Index3& at) { return static_cast<float>(at.z); }),
          .isovalues = {3.5},
          .rays = std::move(rays),
          .naive = {"direct float", 142},
          .known = [](const render::Ray& ray, double isovalue) -> std::optional<double> {
            const double t = (isovalue - ray.origin.z) / ray.direction.z;
            return t >= 0 ? t : no_hit;
          }};
}

HardCase beside_a_large_number() {
  return {.id = "R27",
          .story =
              "Values of a million that differ by one: coefficients that are formed before the isovalue is "
              "subtracted lose every digit.",
          .pack = grid_of<float>(
              cube,
              [](const Index3& at) { return static_cast<float>(1e6 + static_cast<double>(whole_noise(at, 33)) / 16); }),
          .isovalues = {1e6 + 0.84375},
          .rays = all_kinds_of_rays(size, 360, 1),
          .naive = {"paper float", 160}};
}

HardCase far_camera() {
  Rays rays;
  Dice dice(1);
  while (rays.size() < 360) {
    const double distance = std::pow(10, dice.between(3, 6));
    const Vec3 target = dice.point({0, 0, 0}, size), direction = dice.direction();
    rays.push_back(through(target, direction, distance));
  }
  return {.id = "R28",
          .story =
              "The eye is a thousand to a million cells away: a cubic whose variable is counted from the eye has "
              "its roots where single precision has no numbers.",
          .pack = smooth_noise(),
          .isovalues = {0.6},
          .rays = std::move(rays),
          .naive = {"paper float", 167}};
}

HardCase eye_on_the_lattice() {
  Dice dice(1);
  Rays rays;
  while (rays.size() < 300) {
    Vec3 origin = dice.point({0, 0, 0}, size), direction = dice.coin() ? dice.direction() : direction_in_eighths(dice);
    for (int a = 0; a < 3; ++a) {
      if (dice.coin()) origin[a] = std::round(origin[a]);
      if (dice.below(4) == 0) direction[a] = dice.coin() ? 0.0 : -0.0;
    }
    if (direction.length() > 0) rays.push_back({.origin = origin, .direction = direction});
  }
  return {.id = "R30",
          .story =
              "The eye stands in a plane of the lattice or on one of its points, and looks along it: zero times "
              "infinity.",
          .pack = whole_number_noise(),
          .isovalues = {2, 2.5},
          .rays = std::move(rays),
          .naive = {"paper float", 12}};
}

HardCase eye_on_the_surface() {
  Dice dice(1);
  Rays rays;
  while (rays.size() < 300) {
    Vec3 origin = as_point({dice.below(33) + 8, dice.below(33) + 8, 0}) / 8;
    origin.z = 12 - origin.x - origin.y;
    if (!(origin.z > 0.5 && origin.z < 8.5)) continue;
    const Vec3 direction = direction_in_eighths(dice);
    if (std::abs(direction.dot({1, 1, 1})) > 0.01) rays.push_back({.origin = origin, .direction = direction});
  }
  return {.id = "R31",
          .story =
              "The eye stands exactly on the surface, which is inside: a ray that goes on inside meets nothing, one "
              "that goes out meets the surface at once.",
          .pack = grid_of<std::uint8_t>(cube,
                                        [](const Index3& at) { return static_cast<std::uint8_t>(at.x + at.y + at.z); }),
          .isovalues = {12},
          .rays = std::move(rays),
          .naive = {"paper double", 75},
          .known = [](const render::Ray& ray, double) -> std::optional<double> {
            return ray.direction.dot({1, 1, 1}) < 0 ? 0 : no_hit;
          }};
}

HardCase saddle_at_the_isovalue() {
  Dice dice(1);
  Rays rays = all_kinds_of_rays(size, 120, 2);
  while (rays.size() < 360) {
    const Vec3 direction = direction_in_eighths(dice);
    const double z = static_cast<double>(dice.below(256) + 64) / 64;
    if (direction.x * direction.y != 0) rays.push_back(through({middle, middle, z}, direction, 64));
  }
  return {.id = "R22",
          .story =
              "The isovalue is the saddle's own value: rays through the saddle touch it from one side or the "
              "other, and a tolerance would join what is apart.",
          .pack = grid_of<float>(cube,
                                 [](const Index3& at) {
                                   const Vec3 p = as_point(at) - Vec3(middle);
                                   return static_cast<float>(p.x * p.y);
                                 }),
          .isovalues = {0, 1e-9, -1e-9},
          .rays = std::move(rays),
          .naive = {"paper float", 241},
          .direct_may_fail_by = "two roots closer than the values' rounding, or none"};
}

HardCase plateau_slab() {
  return {.id = "R20",
          .story = "Two layers of samples at the isovalue: a slab of roots, entered once and left once.",
          .pack = grid_of<std::uint8_t>(
              cube, [](const Index3& at) { return static_cast<std::uint8_t>(at.x == 4 || at.x == 5 ? 5 : at.y % 3); }),
          .isovalues = {5},
          .rays = all_kinds_of_rays(size, 360, 1),
          .naive = {"paper float", 55},
          .known = [](const render::Ray& ray, double isovalue) -> std::optional<double> {
            const auto part = part_in_box(ray, {0, 0, 0}, size);
            const std::optional<double> entry = entry_into({4, 0, 0}, {5, size.y, size.z})(ray, isovalue);
            // A ray that enters through a side of the volume that the slab reaches is inside
            // already.
            if (!part || !entry || !(*entry > (*part)[0] + 1e-6)) return std::nullopt;
            return entry;
          }};
}

}  // namespace

std::vector<HardCase> chord_cases() {
  std::vector<HardCase> cases{root_on_a_face("R12", true), root_on_a_face("R13", false), root_beside_a_face()};
  cases.push_back({.id = "R15",
                   .story = "Rays in faces between cells, both of which hold them: there the field is bilinear.",
                   .pack = smooth_noise(),
                   .isovalues = {0.6},
                   .rays = rays_in_planes(1, 360, 1),
                   .naive = {"sampled 1", 145}});
  cases.push_back(
      {.id = "R16",
       .story = "Rays along edges, where four cells meet: there the field is linear from sample to sample.",
       .pack = smooth_noise(),
       .isovalues = {0.6, 0.99},
       .rays = rays_in_planes(2, 200, 1),
       .naive = {.reason = "along an edge the field is linear, and every method is right where its arithmetic is"}});
  cases.push_back({.id = "R17",
                   .story = "Rays along diagonals through lattice points: two or three planes are passed at once.",
                   .pack = smooth_noise(),
                   .isovalues = {0.6, 0.95},
                   .rays = rays_along_diagonals(200, 1),
                   .naive = {"preview", 125}});
  cases.push_back({.id = "R18",
                   .story = "Rays that meet the lattice in one of its points, where one of them is the surface's tip: "
                            "a single sample at the isovalue.",
                   .pack = whole_number_noise(),
                   .isovalues = {4},
                   .rays = aimed_rays(size, 3, 360, 1),
                   .naive = {"sampled 1", 42}});
  cases.push_back({.id = "R19",
                   .story = "Whole numbers, and an isovalue that many samples have: zero is a third sign, and belongs "
                            "to the inside.",
                   .pack = whole_number_noise(),
                   .isovalues = {0, 1, 2, 3, 4},
                   .rays = together({stressful_rays(size, 120, 1), all_kinds_of_rays(size, 60, 2)}),
                   .naive = {"paper float", 137},
                   .direct_may_fail_by = ties_at_edges});
  cases.push_back(plateau_slab());
  cases.push_back({.id = "R21",
                   .story = "Faces whose corners lie on alternating sides: the field itself says which are joined, and "
                            "neighbours must agree.",
                   .pack = grid_of<float>(cube,
                                          [](const Index3& at) {
                                            const double sign = (at.x + at.y) % 2 == 0 ? 1 : -1;
                                            return static_cast<float>(sign * (0.2 + noise(at)));
                                          }),
                   .isovalues = {0, 0.125},
                   .rays = all_kinds_of_rays(size, 240, 1),
                   .naive = {"preview", 219}});
  cases.push_back(saddle_at_the_isovalue());
  cases.push_back(
      {.id = "R23",
       .story = "A checkerboard: every cell holds the surface, many of them three times, and no range of "
                "values passes over any.",
       .pack = grid_of<std::int8_t>(
           cube, [](const Index3& at) { return static_cast<std::int8_t>((at.x + at.y + at.z) % 2 ? 100 : -100); }),
       .isovalues = {0, 99},
       .rays = all_kinds_of_rays(size, 240, 1),
       .naive = {"sampled 1", 127},
       .direct_may_fail_by = "rays through the middles of edges touch the surface, up to rounding"});
  cases.push_back(nearly_parallel());
  cases.push_back({.id = "R25",
                   .story = "Rays that pass lattice points by a ten-millionth of a cell and less: chords so short that "
                            "their ends round to one point.",
                   .pack = whole_number_noise(),
                   .isovalues = {3, 3.5},
                   .rays = rays_beside_corners(1e-13, 1e-7, 240, 1),
                   .naive = {"sampled 1", 122}});
  cases.push_back({.id = "R26",
                   .story = "Rays that meet cells in a single point of an edge or corner: chords of length zero.",
                   .pack = whole_number_noise(),
                   .isovalues = {3, 4},
                   .rays = together({rays_along_diagonals(120, 2), aimed_rays(size, 2, 120, 3)}),
                   .naive = {"sampled 1", 107}});
  cases.push_back(beside_a_large_number());
  cases.push_back(far_camera());
  cases.push_back({.id = "R29",
                   .story = "The eye is in a cell that holds the surface: roots behind it must not count, and its side "
                            "is that of the field where it stands.",
                   .pack = smooth_noise(),
                   .isovalues = {0.6},
                   .rays = rays_from_inside(360, 1),
                   .naive = {"sampled 1", 121}});
  cases.push_back(eye_on_the_lattice());
  cases.push_back(eye_on_the_surface());
  cases.push_back({.id = "R33",
                   .story = "Isovalues outside the range of the data, and infinite ones: an empty picture.",
                   .pack = whole_number_noise(),
                   .isovalues = {-1, 4.5, no_hit, -no_hit},
                   .rays = all_kinds_of_rays(size, 60, 1),
                   .naive = {.reason = "the range of the values is asked first"},
                   .known = never});
  cases.push_back({.id = "R34",
                   .story = "Isovalues one unit of rounding below, at and above the value of many samples: what is "
                            "inside changes exactly there.",
                   .pack = block(),
                   .isovalues = {std::nextafter(5.0, 0.0), 5, std::nextafter(5.0, 6.0)},
                   .rays = all_kinds_of_rays(size, 240, 1),
                   .naive = {"paper float", 48},
                   .known = [](const render::Ray& ray, double isovalue) {
                     return isovalue > 5 ? no_hit : entry_into(Vec3(3), Vec3(6))(ray, isovalue);
                   }});
  return cases;
}

}  // namespace rhoray::tests
