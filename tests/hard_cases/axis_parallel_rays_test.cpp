// V01-V04, V06. Directions with components 0, -0 or denormal. There 1 / d is infinite, and 0 *
// infinity, for an origin on a plane, is NaN. Comparison masks then become empty and traversals
// never end.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

float rough(const Index3& at) {
  const auto hash = static_cast<std::uint64_t>((at.z * 101 + at.y) * 103 + at.x) * 0x9e3779b97f4a7c15U;
  return static_cast<float>((hash >> 33) % 1000) - 500;
}

TEST(AxisParallelRays, hit_alike_with_zero_minus_zero_and_denormal_components) {
  TracedDataset grid(volume_of<float>({10, 9, 11}, rough));
  TracedDataset mesh(box_mesh({.cells = {4, 4, 4}, .box = Box3({0, 0, 0}, {9, 8, 10})}, distance_field({4, 4, 4})));
  Dice dice(1);
  int hits = 0, nan_in_slabs = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Vec3 direction(0, 0, 0), target = dice.point({0, 0, 0}, {9, 8, 10});
    direction[static_cast<int>(dice.below(3))] = dice.coin() ? 1 : -1;
    if (dice.coin()) direction[static_cast<int>(dice.below(3))] = dice.coin() ? 0.5 : -2;
    for (int axis = 0; axis < 3; ++axis)
      if (dice.coin()) target[axis] = std::round(target[axis]);
    const render::Ray ray{.origin = target - 20.0 * direction, .direction = direction};
    for (int axis = 0; axis < 3; ++axis)
      for (const double plane : {0.0, 9.0, 8.0, 10.0})
        nan_in_slabs += std::isnan((plane - ray.origin[axis]) * (1 / ray.direction[axis]));
    for (TracedDataset* traced : {&grid, &mesh}) {
      const double iso = traced == &grid ? 0.0 : 2.5;
      const render::Hit hit = traced->first_crossing(ray, iso);
      hits += !hit.is_miss();
      for (const double other : {-0.0, 1e-310, -1e-310, 5e-324}) {
        render::Ray same = ray;
        for (int axis = 0; axis < 3; ++axis)
          if (same.direction[axis] == 0) same.direction[axis] = other;
        EXPECT_TRUE(same_bits(hit, traced->first_crossing(same, iso))) << other;
        EXPECT_TRUE(same_bits(traced->largest_value(ray), traced->largest_value(same))) << other;
      }
    }
  }
  EXPECT_GT(hits, 3000);
  EXPECT_GT(nan_in_slabs, 100) << "the plain slab test no longer fails: is this case still the hard one?";
}

TEST(AxisParallelRays, and_others_need_no_direction_of_unit_length) {
  TracedDataset traced(volume_of<float>({10, 9, 11}, rough));
  Dice dice(2);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 direction = dice.direction();
    const render::Ray ray{.origin = dice.point({0, 0, 0}, {9, 8, 10}) - 30.0 * direction, .direction = direction};
    const render::Hit hit = traced.first_crossing(ray, 0);
    for (const double length : {0x1p-66, 0x1p66, 0x1p-700}) {
      render::Ray scaled = ray;
      scaled.direction *= length;
      const render::Hit other = traced.first_crossing(scaled, 0);
      ASSERT_EQ(hit.is_miss(), other.is_miss());
      if (hit.is_miss()) continue;
      EXPECT_EQ(other.t * length, hit.t);
      EXPECT_EQ(other.cell, hit.cell);
    }
  }
}

}  // namespace
}  // namespace rhoray::tests
