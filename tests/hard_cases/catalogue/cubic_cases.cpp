// R. A ray in a trilinear cell. The field along it is a cubic, and in each case some method of
// finding its first root fails.
#include <array>

#include "tests/hard_cases/catalogue/cube_of_samples.h"

namespace rhoray::tests {
namespace {

/// 1 for x >= 2 and y >= 2, else 0: in the cells at x, y in [1, 2] the field is (x - 1) (y - 1).
Pack step_in_two_axes() {
  return grid_of<float>({4, 4, 12}, [](const Index3& at) { return at.x >= 2 && at.y >= 2 ? 1.0F : 0.0F; });
}

/// Rays along which that field is s (1 - s), s = 1/2 + (t - t_middle) * speed: from 0 up to 1/4 and
/// back in one cell.
Rays rays_over_the_hump(std::size_t count, std::uint64_t seed) {
  constexpr std::array<double, 4> speeds{1.0, 0.25, 4.0, 1024.0};
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const double speed = dice.one_of(speeds), z = static_cast<double>(dice.below(128) + 192) / 64;
    const Vec3 direction = speed * Vec3(1, -1, static_cast<double>(dice.below(33) - 16) / 16);
    rays.push_back({.origin = {0.5, 2.5, z}, .direction = direction});
  }
  return rays;
}

/// The first root of s (1 - s) = isovalue: s = 1/2 is at one unit of t * speed.
std::optional<double> on_the_hump(const render::Ray& ray, double isovalue) {
  if (isovalue > 0.25) return no_hit;
  return (1 - std::sqrt(0.25 - isovalue)) / ray.direction.x;
}

Pack three_planes() {
  return grid_of<float>(cube, [](const Index3& at) {
    const Vec3 p = as_point(at) - Vec3(middle);
    return static_cast<float>(p.x * p.y * p.z);
  });
}

/// The product of distances from three planes is zero in each of them.
std::optional<double> first_of_three_planes(const render::Ray& ray, double) {
  std::array<double, 3> times;
  for (int a = 0; a < 3; ++a)
    times[static_cast<std::size_t>(a)] = ray.direction[a] == 0 ? no_hit : (middle - ray.origin[a]) / ray.direction[a];
  std::sort(times.begin(), times.end());
  const auto part = part_in_box(ray, {0, 0, 0}, size);
  if (!part || !(times[0] > (*part)[0] + 1e-9) || !(times[0] < (*part)[1] - 1e-9)) return std::nullopt;
  // The ray returns to its side.
  if (times[1] - times[0] < 1e-9 && times[2] - times[1] > 1e-9) return std::nullopt;
  return times[0];
}

Rays rays_through(const Vec3& target, double spread, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const Vec3 d = direction_in_eighths(dice);
    if (d.x * d.y * d.z == 0) continue;
    const Vec3 shift = spread * dice.point({-1, -1, -1}, {1, 1, 1});
    rays.push_back(through(target + shift, d, 16));
  }
  return rays;
}

HardCase nearly_planar() {
  Rays rays = all_kinds_of_rays(size, 240, 1);
  Dice dice(2);
  for (render::Ray& ray : random_rays(size, 120, 3)) {
    ray.direction[static_cast<int>(dice.below(3))] *= 1e-6;
    ray.origin = ray.at(1);
    rays.push_back(through(dice.point({0, 0, 0}, size), ray.direction, 30));
  }
  return {.id = "R01",
          .story =
              "Values of a plane, rounded to single precision: the cubic's leading coefficient is nothing but "
              "rounding, and a closed form that divides by it loses its root.",
          .pack = grid_of<float>(
              cube, [](const Index3& at) { return static_cast<float>(Vec3(0.31, 0.52, 0.73).dot(as_point(at))); }),
          .isovalues = {6.1},
          .rays = std::move(rays),
          .naive = {"paper float", 86}};
}

HardCase bilinear() {
  return {.id = "R02",
          .story =
              "The field is x y: no cubic term at all, but two roots on many rays. A normalised cubic divides by "
              "zero.",
          .pack = grid_of<std::uint8_t>(cube, [](const Index3& at) { return static_cast<std::uint8_t>(at.x * at.y); }),
          .isovalues = {20.5},
          .rays = all_kinds_of_rays(size, 360, 1),
          .naive = {"paper float", 40}};
}

HardCase linear() {
  const Vec3 slope(3, -2, 5);
  return {.id = "R03",
          .story = "Whole numbers in a plane: cubic and quadratic terms vanish, and the plane tells the exact t.",
          .pack = grid_of<float>(cube, [=](const Index3& at) { return static_cast<float>(slope.dot(as_point(at))); }),
          .isovalues = {19.7},
          .rays = all_kinds_of_rays(size, 360, 1),
          .naive = {"paper float", 51},
          .known = plane_in_box(slope, size)};
}

HardCase constant() {
  return {.id = "R04",
          .story = "Nothing varies, and the isovalue lies beside: no root anywhere, though every coefficient is zero.",
          .pack = grid_of<float>(cube, [](const Index3&) { return 5.0F; }),
          .isovalues = {4.5, 5.5},
          .rays = all_kinds_of_rays(size, 120, 1),
          .naive = {.reason = "the range of a cell's values is asked before any coefficient"},
          .known = never};
}

HardCase block_at_the_isovalue() {
  return {.id = "R05",
          .story =
              "A block of samples at the isovalue: every point of it is a root. The one hit is where a ray enters "
              "the block.",
          .pack = block(),
          .isovalues = {5},
          .rays = all_kinds_of_rays(size, 360, 1),
          .naive = {"paper float", 29},
          .known = entry_into(Vec3(3), Vec3(6))};
}

HardCase tangent() {
  return {.id = "R06",
          .story =
              "From outside the field reaches the isovalue at one point and turns back: a double root. It is a "
              "hit, and a touch; no sign changes.",
          .pack = step_in_two_axes(),
          .isovalues = {0.25},
          .rays = rays_over_the_hump(200, 1),
          .naive = {"sampled 1", 100},
          .known = on_the_hump};
}

HardCase tangent_from_below() {
  return {.id = "R07",
          .story = "As R06, but the field stays a ten-millionth below: no hit, whatever a discriminant says.",
          .pack = step_in_two_axes(),
          .isovalues = {0.25 * (1 + 1e-7), std::nextafter(0.25, 1)},
          .rays = rays_over_the_hump(200, 1),
          .naive = {"direct float", 79},
          .known = on_the_hump};
}

HardCase tangent_from_above() {
  return {.id = "R08",
          .story =
              "As R06, but the field goes above by so little that its two roots lie a ten-thousandth of a cell "
              "apart: samples step over both.",
          .pack = step_in_two_axes(),
          .isovalues = {0.25 - 2.5e-9},
          .rays = rays_over_the_hump(200, 1),
          .naive = {"sampled 0.5", 94},
          .known = on_the_hump};
}

HardCase triple_root() {
  return {.id = "R09",
          .story =
              "The product of distances from three planes, along rays through their common point: a triple root, "
              "where Newton's steps only halve and an arc cosine leaves its domain.",
          .pack = three_planes(),
          .rays = rays_through(Vec3(middle), 0, 200, 1),
          .naive = {"sampled 1", 100},
          .known = first_of_three_planes};
}

HardCase three_roots() {
  return {.id = "R10",
          .story =
              "The same three planes, passed one after another inside one cell: three roots, and the ends of the "
              "chord show one. The smallest is the hit.",
          .pack = three_planes(),
          .rays = rays_through(Vec3(middle), 0.2, 300, 1),
          .naive = {"preview", 143},
          .known = first_of_three_planes};
}

HardCase two_roots() {
  return {.id = "R11",
          .story = "In and out again inside one cell, with both ends of the chord outside.",
          .pack = step_in_two_axes(),
          .isovalues = {0.2},
          .rays = rays_over_the_hump(200, 1),
          .naive = {"preview", 99},
          .known = on_the_hump};
}

}  // namespace

std::vector<HardCase> cubic_cases() {
  return {nearly_planar(),
          bilinear(),
          linear(),
          constant(),
          block_at_the_isovalue(),
          tangent(),
          tangent_from_below(),
          tangent_from_above(),
          triple_root(),
          three_roots(),
          two_roots()};
}

}  // namespace rhoray::tests
