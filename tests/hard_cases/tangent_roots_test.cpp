// R06-R08, R11. A ray that dips into the inside and leaves it within one cell. Both ends of its
// chord lie outside, so tests of the ends, or steps of a cell, see nothing. Near the tangent the
// two roots coincide.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

TEST(TangentRoots, are_found_as_long_as_the_values_tell_them_apart) {
  // The field in the middle cell is u v. Along u + v = 1 it is s (1 - s), at most 1/4.
  TracedDataset traced(
      volume_of<double>({4, 4, 4}, [](const Index3& at) { return at.x >= 2 && at.y >= 2 ? 1.0 : 0.0; }));
  const render::Ray ray{.origin = {0.5, 2.5, 1.3}, .direction = {1, -1, 0}};
  int dips = 0, lost_by_ends = 0;
  for (int exponent = 1; exponent <= 15; ++exponent) {
    const double gap = std::pow(10, -exponent), iso = 0.25 - gap;
    const render::Hit hit = traced.first_crossing(ray, iso);
    ASSERT_FALSE(hit.is_miss()) << "gap " << gap;
    // t = 1/2 enters the cell; s (1 - s) = 1/4 - gap at s = 1/2 - sqrt(gap). Values round by 1e-16.
    EXPECT_NEAR(hit.t, 0.5 + 0.5 - std::sqrt(gap), 2e-16 / std::sqrt(gap) + 1e-15);
    EXPECT_TRUE(traced.first_crossing(ray, 0.25 + gap).is_miss()) << "gap " << -gap;
    ++dips;
    lost_by_ends += 0 < iso;  // both ends of the chord are 0: outside
  }
  EXPECT_EQ(lost_by_ends, dips) << "the ends of the chord tell: is this case still the hard one?";
  // Either answer is right; a hit must be at the touching point.
  const render::Hit touch = traced.first_crossing(ray, 0.25);
  EXPECT_TRUE(touch.is_miss() || std::abs(touch.t - 1) < 1e-7);
}

TEST(TangentRoots, are_found_on_rays_at_every_distance_from_a_ridge) {
  TracedDataset traced(
      volume_of<double>({4, 4, 4}, [](const Index3& at) { return at.x >= 2 && at.y >= 2 ? 1.0 : 0.0; }));
  Dice dice(1);
  int hits = 0, lost_by_ends = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    // Parallel to the diagonal u + v = 1, shifted: the largest value on it is ((1 + shift) / 2)^2
    // for shift < 0.
    const double shift = -std::pow(10, dice.between(-9, -1)), largest = (1 + shift) * (1 + shift) / 4;
    const double iso = largest * (1 - std::pow(10, dice.between(-12, -2)));
    const render::Ray ray{.origin = {0.5 + shift, 2.5, dice.between(1, 2)}, .direction = {1, -1, 0}};
    const render::Hit hit = traced.first_crossing(ray, iso);
    ASSERT_FALSE(hit.is_miss());
    const Vec3 p = ray.at(hit.t) - Vec3(1, 1, 0);
    EXPECT_NEAR(p.x * p.y, iso, 1e-14);
    ++hits;
    lost_by_ends += iso > 0;
  }
  EXPECT_EQ(lost_by_ends, hits);
}

}  // namespace
}  // namespace rhoray::tests
