// V. The traversal from cell to cell: directions, boxes and sizes at which it loses its cell, stops
// or never ends.
#include <array>

#include "tests/hard_cases/catalogue/case_parts.h"

namespace rhoray::tests {
namespace {

const Index3 cube(10, 10, 10);
const Vec3 size(9);

Pack noise_grid(const Index3& count = cube, const Affine& world_from_grid = {},
                const preprocess::PackVolumeOptions& options = {}) {
  return grid_of<float>(
      count, [](const Index3& at) { return static_cast<float>(noise(at)); }, world_from_grid, options);
}

template <class Change>
Rays changed(Rays rays, Change&& change) {
  Dice dice(99);
  for (render::Ray& ray : rays) change(ray, dice);
  return rays;
}

/// Rays through points inside the box, from t = 30 back. Some components of the direction are set.
Rays with_components(int count_of_axes, std::vector<double> components, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    Vec3 direction = dice.direction(), target = dice.point({0, 0, 0}, size);
    const auto first = dice.below(3);
    for (int n = 0; n < count_of_axes; ++n) {
      const int a = static_cast<int>((first + n) % 3);
      direction[a] = components[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(components.size())))];
      if (dice.coin()) target[a] = std::round(target[a]);
    }
    rays.push_back(through(target, direction, 30));
  }
  return rays;
}

Rays rays_that_are_none() {
  const double nan = std::nan(""), infinity = no_hit;
  Rays rays;
  for (const double bad : {nan, infinity, -infinity})
    for (int a = 0; a < 3; ++a) {
      render::Ray ray{.origin = {4, 4, -5}, .direction = {0.1, 0.1, 1}};
      ray.direction[a] = bad;
      rays.push_back(ray);
      ray = {.origin = {4, 4, -5}, .direction = {0.1, 0.1, 1}};
      ray.origin[a] = bad;
      rays.push_back(ray);
    }
  rays.push_back({.origin = {4, 4, 4}, .direction = {0, 0, 0}});
  rays.push_back({.origin = {4, 4, 4}, .direction = {-0.0, 0, -0.0}});
  return rays;
}

/// Rays in the planes of the box's sides, in `axes` planes at once.
Rays rays_on_the_box(int axes, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    Vec3 direction = dice.coin() ? dice.direction() : direction_in_eighths(dice);
    Vec3 target = as_point({dice.below(577), dice.below(577), dice.below(577)}) / 64;
    const auto first = dice.below(3);
    for (int n = 0; n < axes; ++n) {
      const int a = static_cast<int>((first + n) % 3);
      target[a] = dice.coin() ? 0 : size[a];
      direction[a] = 0;
    }
    if (direction.length() > 0) rays.push_back(through(target, direction, 32));
  }
  return rays;
}

/// Rays that meet an edge or corner of the box.
Rays rays_at_edges_of_the_box(std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    Vec3 target = as_point({dice.below(577), dice.below(577), dice.below(577)}) / 64;
    const auto free_axis = dice.below(4);  // 3: a corner
    for (int a = 0; a < 3; ++a)
      if (a != free_axis) target[a] = dice.coin() ? 0 : size[a];
    rays.push_back(through(target, direction_in_eighths(dice), 32));
  }
  return rays;
}

Rays rays_that_pass_by(std::size_t count) {
  Dice dice(1);
  Rays rays;
  while (rays.size() < count) {
    const int axis = static_cast<int>(dice.below(3));
    const bool high = dice.coin();
    Vec3 target = dice.point({0, 0, 0}, size), direction = dice.direction();
    if (dice.coin()) {  // beside a side of the box, by one unit of rounding
      target[axis] = high ? std::nextafter(size[axis], 100.0) : std::nextafter(0.0, -1.0);
      direction[axis] = 0;
      rays.push_back(through(target, direction, 0));
      rays.back().origin -= 30.0 * direction;
    } else {  // behind the box, looking away from it
      target[axis] = high ? size[axis] + 1e-9 : -1e-9;
      direction[axis] = (high ? 1 : -1) * std::abs(direction[axis]);
      rays.push_back({.origin = target, .direction = direction});
    }
  }
  return rays;
}

HardCase in_thin_cells() {
  const Affine map{{1e-4, 0, 0}, {0, 1, 0}, {0, 0, 1e4}, {0, 0, 0}};
  Rays rays = all_kinds_of_rays(size, 360, 1);
  for (render::Ray& ray : rays) ray.origin = map.point(ray.origin), ray.direction = map.vector(ray.direction);
  return {.id = "V17",
          .story =
              "Cells a hundred million times as long as they are wide: a tolerance in world units is larger than a "
              "cell.",
          .pack = noise_grid(cube, map),
          .isovalues = {0.6},
          .rays = std::move(rays),
          .naive = {"sampled 1", 163}};
}

HardCase far_from_the_origin() {
  const Affine map{{1e-3, 0, 0}, {0, 1e-3, 0}, {0, 0, 1e-3}, {1e6, -2e6, 3e6}};
  Rays rays = random_rays(size, 300, 1);
  for (render::Ray& ray : rays) ray.origin = map.point(ray.origin), ray.direction = map.vector(ray.direction);
  return {.id = "V18",
          .story =
              "Cells of a thousandth, a million from the origin: in single precision the world has no two points "
              "in one of them.",
          .pack = noise_grid(cube, map),
          .isovalues = {0.6},
          .rays = std::move(rays),
          .naive = {"paper float", 70}};
}

HardCase long_volume() {
  Dice dice(1);
  Rays rays;
  while (rays.size() < 150)
    rays.push_back({.origin = {-1, dice.between(0.5, 2.5), dice.between(0.5, 2.5)},
                    .direction = {1, dice.between(-5e-5, 5e-5), dice.between(-5e-5, 5e-5)}});
  return {.id = "V19",
          .story = "Rays through ten thousand cells: a position that is summed up step by step drifts away.",
          .pack = grid_of<float>(
              {10000, 4, 4},
              [](const Index3& at) { return static_cast<float>(noise(at) * 1e-3 + static_cast<double>(at.x)); }),
          .isovalues = {9990.25},
          .rays = std::move(rays),
          .naive = {"paper float", 75}};
}

HardCase thin_plate() {
  return {
      .id = "V22",
      .story = "A plate and a hair of single samples: steps of a cell go through without seeing them.",
      .pack = grid_of<std::uint8_t>(
          {24, 24, 24},
          [](const Index3& at) { return static_cast<std::uint8_t>(at.y == 11 || (at.x == 5 && at.z == 7) ? 100 : 0); }),
      .isovalues = {80},
      .rays = all_kinds_of_rays(Vec3(23), 360, 1),
      .naive = {"sampled 1", 61}};
}

}  // namespace

std::vector<HardCase> traversal_cases() {
  std::vector<HardCase> cases;
  const auto add = [&](HardCase hard_case) { cases.push_back(std::move(hard_case)); };
  add({.id = "V01",
       .story = "One component of the direction is zero: a plane's time is infinite, or no number.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = with_components(1, {0.0}, 300, 1),
       .naive = {"sampled 1", 137}});
  add({.id = "V02",
       .story = "Two components are zero: the walk goes along one axis.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = with_components(2, {0.0}, 300, 2),
       .naive = {"sampled 1", 21}});
  add({.id = "V03",
       .story = "Zero with a minus sign: its sign is that of no step.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = with_components(2, {0.0, -0.0}, 300, 3),
       .naive = {"sampled 1", 19}});
  add({.id = "V04",
       .story = "Components so small that their inverse is infinite, and others that just have one.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = with_components(1, {1e-310, -1e-310, 5e-324, 1e-300, -1e-40, 1e-40}, 300, 4),
       .naive = {"sampled 1", 133}});
  add({.id = "V05",
       .story = "Rays that are none: no direction, or numbers that are no places.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = rays_that_are_none(),
       .naive = {.reason = "all ways share the walk, which ends at once"},
       .known = never});
  add({.id = "V06",
       .story = "Directions of any length: only t changes with it.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = changed(all_kinds_of_rays(size, 360, 5),
                       [](render::Ray& ray, Dice& dice) {
                         ray.direction *= dice.one_of(std::array{1e-20, 1e20, 1e-5, 1e9});
                       }),
       .naive = {"paper float", 150}});
  add({.id = "V07",
       .story = "Rays in a side of the volume: it belongs to the volume.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = rays_on_the_box(1, 300, 6),
       .naive = {"sampled 1", 133}});
  add({.id = "V08",
       .story = "Rays along edges of the volume, and rays that meet it in a point of an edge or in a corner.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = together({rays_on_the_box(2, 150, 7), rays_at_edges_of_the_box(150, 8)}),
       .naive = {"sampled 1", 40}});
  add({.id = "V09",
       .story = "Rays that pass the volume by one unit of rounding, and rays that look away from it.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = rays_that_pass_by(300),
       .naive = {.reason = "all ways share the box test"},
       .known = never});
  add({.id = "V10",
       .story = "Nothing to hit and a ray without end.",
       .pack = grid_of<float>({40, 40, 40}, [](const Index3&) { return 0.0F; }),
       .isovalues = {1},
       .rays = all_kinds_of_rays(Vec3(39), 120, 9),
       .naive = {.reason = "the range of the values is asked first"},
       .known = never});
  add({.id = "V11",
       .story = "Rays along and across the borders of macrocells: all levels must agree where a ray is.",
       .pack = noise_grid({41, 41, 41}, {}, {.macro_factor = 3}),
       .isovalues = {0.9},
       .rays = changed(together({aimed_rays(Vec3(40), 2, 120, 10), aimed_rays(Vec3(40), 3, 120, 11)}),
                       [](render::Ray& ray, Dice& dice) {
                         for (int a = 0; a < 3; ++a)
                           if (dice.coin()) ray.origin[a] = 3 * std::round(ray.origin[a] / 3);
                       }),
       .naive = {"sampled 1", 59}});
  add({.id = "V12",
       .story = "Directions in which a step forward in t is lost to rounding: progress is in whole cells.",
       .pack = noise_grid(),
       .isovalues = {0.6},
       .rays = changed(all_kinds_of_rays(size, 360, 12),
                       [](render::Ray& ray, Dice& dice) {
                         ray.origin -= dice.one_of(std::array{1e6, 1e9, 1e12}) * ray.direction;
                       }),
       .naive = {"paper float", 166}});
  add({.id = "V13",
       .story = "Rays in and across the borders of bricks, where a cell's samples come from up to eight of them.",
       .pack = noise_grid({22, 22, 22}, {}, {.brick_edge = 7}),
       .isovalues = {0.6},
       .rays = changed(all_kinds_of_rays(Vec3(21), 360, 13),
                       [](render::Ray& ray, Dice& dice) {
                         const int a = static_cast<int>(dice.below(3));
                         if (dice.coin()) ray.direction[a] = 0, ray.origin[a] = static_cast<double>(7 * dice.below(4));
                       }),
       .naive = {"sampled 1", 170}});
  add({.id = "V14",
       .story = "Sizes that are no multiples of the brick: what fills the last bricks is no data.",
       .pack = noise_grid({11, 17, 7}, {}, {.brick_edge = 8}),
       .isovalues = {0.6},
       .rays = all_kinds_of_rays({10, 16, 6}, 360, 14),
       .naive = {"sampled 1", 158}});
  add({.id = "V15",
       .story = "Two samples on an axis or on all: one layer of cells, or one cell.",
       .pack = noise_grid({2, 9, 2}),
       .isovalues = {0.3, 0.5},
       .rays = all_kinds_of_rays({1, 8, 1}, 200, 15),
       .naive = {"preview", 80}});
  add(in_thin_cells());
  add(far_from_the_origin());
  add(long_volume());
  add({.id = "V20",
       .story = "Rays that pass two or three planes at bitwise the same t: one that steps on two axes at once skips a "
                "cell.",
       .pack = grid_of<float>(cube, [](const Index3& at) { return static_cast<float>(whole_noise(at, 3) == 0); }),
       .isovalues = {0.25, 1},
       .rays = changed(aimed_rays(size, 3, 200, 16),
                       [](render::Ray& ray, Dice&) {
                         for (int a = 0; a < 3; ++a) ray.direction[a] = ray.direction[a] < 0 ? -0.5 : 0.5;
                         for (int a = 0; a < 3; ++a)
                           ray.origin[a] = std::round(ray.origin[a] + 4) - 32 * ray.direction[a];
                       }),
       .naive = {"sampled 1", 3}});
  add({.id = "V21",
       .story = "Rays through corners of the box of which the entry time rounds beyond the exit time.",
       .pack = noise_grid(),
       .isovalues = {0.3},
       .rays = changed(rays_at_edges_of_the_box(360, 17),
                       [](render::Ray& ray, Dice& dice) {
                         ray.direction += 1e-3 * dice.direction();
                         ray.origin += 1e-15 * dice.direction();
                       }),
       .naive = {"sampled 1", 54}});
  add(thin_plate());
  return cases;
}

}  // namespace rhoray::tests
