#include "render/traverse/ray_box.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::clip_to_lattice;
using render::PlaneTimes;
using render::Ray;
using render::Segment;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::optional<Segment> clip(const Ray& ray, const Index3& size) {
  return clip_to_lattice(ray, PlaneTimes(ray), size);
}

TEST(ClipToLattice, gives_the_part_inside_the_box) {
  const std::optional<Segment> part = clip({.origin = {-3, 1, 1}, .direction = {2, 0, 0}}, {4, 2, 2});
  ASSERT_TRUE(part);
  EXPECT_EQ(part->t_in, 1.5);
  EXPECT_EQ(part->t_out, 3.5);
}

TEST(ClipToLattice, agrees_with_exact_slabs) {
  const Index3 size(5, 7, 3);
  int inside = 0, outside = 0, near_the_edge = 0;
  for (const Ray& ray : stressful_rays({5, 7, 3}, 4000, 11)) {
    if (std::abs(ray.origin.x) + std::abs(ray.origin.y) + std::abs(ray.origin.z) > 1e7) continue;
    Rational t_in = exact(ray.t_min), t_out = ray.t_max == infinity ? Rational(1) * exact(1e300) : exact(ray.t_max);
    bool misses = false;
    for (int axis = 0; axis < 3; ++axis) {
      const Rational o = exact(ray.origin[axis]), d = exact(ray.direction[axis]), n = size[axis];
      if (std::abs(ray.direction[axis]) < 6e-309) {
        misses = misses || o < 0 || o > n;
        continue;
      }
      Rational enter = -o / d, leave = (n - o) / d;
      if (enter > leave) std::swap(enter, leave);
      if (enter > t_in) t_in = enter;
      if (leave < t_out) t_out = leave;
    }
    const std::optional<Segment> part = clip(ray, size);
    const double length = ray.direction.length();
    const double tolerance = 1e-15 * (ray.origin.length() + 30) / length;  // of t
    if (!misses && abs(t_out - t_in) < exact(16 * tolerance)) {
      ++near_the_edge;  // touches the box up to rounding: both results are correct
    } else if (misses || t_out < t_in) {
      EXPECT_FALSE(part);
      ++outside;
    } else {
      ASSERT_TRUE(part);
      // Errors of t are relative to the distance that t corresponds to along the slowest axis.
      double slowest = infinity;
      for (int axis = 0; axis < 3; ++axis)
        if (std::abs(ray.direction[axis]) > 1e-12 * length) slowest = std::min(slowest, std::abs(ray.direction[axis]));
      EXPECT_NEAR(part->t_in, rounded(t_in), tolerance * length / slowest + 4e-16 * std::abs(part->t_in));
      EXPECT_NEAR(part->t_out, rounded(t_out), tolerance * length / slowest + 4e-16 * std::abs(part->t_out));
      ++inside;
    }
  }
  EXPECT_GT(inside, 1500);
  EXPECT_GT(outside, 30);
  EXPECT_LT(near_the_edge, 600);
}

TEST(ClipToLattice, keeps_a_ray_that_lies_in_a_face_or_an_edge) {
  for (const double y : {0.0, 2.0})
    for (const double z : {0.5, 0.0, 2.0})
      for (const double zero : {0.0, -0.0}) {
        const std::optional<Segment> part = clip({.origin = {-1, y, z}, .direction = {1, zero, zero}}, {4, 2, 2});
        ASSERT_TRUE(part);
        EXPECT_EQ(part->t_in, 1);
        EXPECT_EQ(part->t_out, 5);
      }
  EXPECT_FALSE(clip({.origin = {-1, std::nextafter(2.0, 3.0), 1}, .direction = {1, 0, 0}}, {4, 2, 2}));
  EXPECT_FALSE(clip({.origin = {-1, -5e-324, 1}, .direction = {1, 0, 0}}, {4, 2, 2}));
}

TEST(ClipToLattice, keeps_nothing_behind_the_start_or_beyond_the_end) {
  EXPECT_FALSE(clip({.origin = {-1, 1, 1}, .direction = {-1, 0, 0}}, {4, 2, 2}));
  EXPECT_FALSE(clip({.origin = {-1, 1, 1}, .direction = {1, 0, 0}, .t_min = 0, .t_max = 0.5}, {4, 2, 2}));
  EXPECT_FALSE(clip({.origin = {-1, 1, 1}, .direction = {1, 0, 0}, .t_min = 6}, {4, 2, 2}));
  EXPECT_FALSE(clip({.origin = {1, 1, 1}, .direction = {1, 0, 0}, .t_min = 1, .t_max = 0}, {4, 2, 2}));
}

TEST(ClipToLattice, gives_nothing_for_a_direction_of_zero) {
  for (const double zero : {0.0, -0.0, 1e-310, -5e-324})
    EXPECT_FALSE(clip({.origin = {1, 1, 1}, .direction = {zero, zero, zero}}, {4, 2, 2})) << zero;
}

// A NaN component once counted as one that does not move, and an infinite origin gave a part from
// infinity to infinity.
TEST(ClipToLattice, gives_nothing_for_numbers_that_are_not_finite) {
  for (const double bad : {nan, infinity, -infinity})
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) {
        Ray ray{.origin = {1, 1, 1}, .direction = {sign, sign, sign}};
        ray.direction[axis] = bad;
        EXPECT_FALSE(clip(ray, {4, 2, 2})) << bad << " in direction";
        ray = {.origin = {1, 1, 1}, .direction = {sign, sign, sign}};
        ray.origin[axis] = bad;
        EXPECT_FALSE(clip(ray, {4, 2, 2})) << bad << " in origin";
        ray.direction[axis] = 0;
        EXPECT_FALSE(clip(ray, {4, 2, 2})) << bad << " in origin, on an axis that does not move";
      }
  EXPECT_FALSE(clip({.origin = {1, 1, 1}, .direction = {1, 0, 0}, .t_min = nan}, {4, 2, 2}));
  EXPECT_FALSE(clip({.origin = {1, 1, 1}, .direction = {1, 0, 0}, .t_min = infinity}, {4, 2, 2}));
}

TEST(ClipToLattice, gives_nothing_where_t_is_beyond_all_numbers) {
  EXPECT_FALSE(clip({.origin = {-10, 1, 1}, .direction = {1e-308, 0, 0}}, {400, 2, 2}));
  EXPECT_TRUE(clip({.origin = {-10, 1, 1}, .direction = {1e-300, 0, 0}}, {400, 2, 2}));
}

TEST(PlaneTimes, rise_with_the_planes_along_the_ray) {
  Dice dice(3);
  for (int trial = 0; trial < 2000; ++trial) {
    const Ray ray{.origin = dice.point({-1e3, -1, -1}, {1e3, 1e9, 1}), .direction = dice.direction()};
    const PlaneTimes planes(ray);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 40; ++k) {
        const int next = k + planes.step(axis);
        EXPECT_LE(planes.at(axis, k), planes.at(axis, next));
      }
  }
}

}  // namespace
}  // namespace rhoray::tests
