#include "render/tets/reference/cluster_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::render {
namespace {

using tests::Dice;
using tests::Rational;

formats::BoxBlock boxes_of(Dice& dice) {
  formats::BoxBlock block;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t e = 0; e < 8; ++e) {
      // Many planes at integers, where the stressful rays pass many at once.
      auto lo = static_cast<float>(dice.between(-0.5, 4)), size = static_cast<float>(dice.between(0, 1));
      if (dice.coin()) lo = std::round(lo), size = static_cast<float>(dice.below(3));
      block.lo[axis][e] = lo;
      block.hi[axis][e] = lo + size;
    }
  return block;
}

struct ExactPart {
  bool is_met = true;
  Rational in, out;
};

/// Returns the part of a ray in a closed box, in rational numbers.
ExactPart exact_part(const Ray& ray, const formats::BoxBlock& block, std::size_t entry) {
  ExactPart part{.in = Rational(ray.t_min), .out = Rational(std::min(ray.t_max, 1e30))};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Rational origin(ray.origin[static_cast<int>(axis)]), d(ray.direction[static_cast<int>(axis)]);
    const Rational lo(block.lo[axis][entry]), hi(block.hi[axis][entry]);
    if (d == 0) {
      part.is_met = part.is_met && lo <= origin && origin <= hi;
      continue;
    }
    const Rational a = (lo - origin) / d, b = (hi - origin) / d;
    part.in = std::max(part.in, std::min(a, b));
    part.out = std::min(part.out, std::max(a, b));
  }
  part.is_met = part.is_met && part.in <= part.out;
  return part;
}

TEST(BoxRay, misses_no_box_that_the_ray_touches_and_no_part_of_it) {
  Dice dice(5);
  int met = 0, said = 0, touched = 0;
  for (Ray ray : tests::stressful_rays({4, 4, 4}, 1500, 6)) {
    for (int axis = 0; axis < 3; ++axis)  // its inverse would not be finite: counts as zero
      if (std::abs(ray.direction[axis]) < 1e-300) ray.direction[axis] = 0;
    const formats::BoxBlock block = boxes_of(dice);
    const BoxRay::Parts parts = BoxRay(ray, 1).meet(block);
    for (std::size_t e = 0; e < 8; ++e) {
      const ExactPart exact = exact_part(ray, block, e);
      said += parts.is_met(e);
      if (!exact.is_met) continue;
      ++met;
      touched += exact.in == exact.out;
      ASSERT_TRUE(parts.is_met(e));
      ASSERT_LE(Rational(parts.t_in[e]), exact.in);
      ASSERT_GE(parts.t_out[e], exact.out.convert_to<double>() * (1 - 1e-15));
    }
  }
  EXPECT_GT(met, 300);
  EXPECT_GT(touched, 5);
  EXPECT_LT(said, met + met / 20);
}

TEST(BoxRay, says_the_same_in_any_unit) {
  Dice dice(7);
  for (const Ray& ray : tests::stressful_rays({4, 4, 4}, 200, 8)) {
    const formats::BoxBlock block = boxes_of(dice);
    const BoxRay::Parts one = BoxRay(ray, 1).meet(block);
    const Ray scaled{ray.origin * 0x1p40, ray.direction * 0x1p40, ray.t_min, ray.t_max};
    const BoxRay::Parts other = BoxRay(scaled, 0x1p40).meet(block);
    for (std::size_t e = 0; e < 8; ++e) {
      ASSERT_EQ(one.is_met(e), other.is_met(e));
      if (one.is_met(e)) {
        ASSERT_EQ(one.t_in[e], other.t_in[e]);
      }
    }
  }
}

TEST(BoxRay, meets_nothing_where_a_number_is_not_finite_and_no_empty_box) {
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  formats::BoxBlock block;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    block.lo[axis].fill(-1);
    block.hi[axis].fill(1);
    block.lo[axis][7] = std::numeric_limits<float>::infinity();
    block.hi[axis][7] = -block.lo[axis][7];
  }
  const auto met = [&](const Ray& ray) {
    const BoxRay::Parts parts = BoxRay(ray, 1).meet(block);
    int count = 0;
    for (std::size_t e = 0; e < 8; ++e) count += parts.is_met(e);
    return count;
  };
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(1, 2, -3)})
    EXPECT_EQ(met({.origin = -3.0 * direction, .direction = direction}), 7);
  EXPECT_EQ(met({.origin = {0, 0, 0}, .direction = {0, 0, 0}}), 0);
  EXPECT_EQ(met({.origin = {0, 0, 0}, .direction = {nan, 0, 1}}), 0);
  EXPECT_EQ(met({.origin = {0, 0, 0}, .direction = {infinity, 0, 1}}), 0);
  EXPECT_EQ(met({.origin = {nan, 0, 0}, .direction = {1, 0, 0}}), 0);
  EXPECT_EQ(met({.origin = {-infinity, 0, 0}, .direction = {1, 0, 0}}), 0);
  EXPECT_EQ(met({.origin = {-3, 0, 0}, .direction = {1, 0, 0}, .t_min = nan}), 0);
  EXPECT_EQ(met({.origin = {-3, 0, 0}, .direction = {1, 0, 0}, .t_min = 5}), 0);
  EXPECT_EQ(met({.origin = {-3, 0, 0}, .direction = {1, 0, 0}, .t_max = 1}), 0);
}

}  // namespace
}  // namespace rhoray::render
