#include "render/cell/trilinear.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::Cubic;
using render::TrilinearCell;

Rational exact_at(const TrilinearCell& cell, const ExactVec3& p) {
  Rational sum = 0;
  for (std::size_t c = 0; c < 8; ++c)
    sum += exact(cell.corner[c]) * (c & 1 ? p.x : 1 - p.x) * (c & 2 ? p.y : 1 - p.y) * (c & 4 ? p.z : 1 - p.z);
  return sum;
}

TrilinearCell any_cell(Dice& dice, double offset = 0, double scale = 1) {
  TrilinearCell cell;
  for (double& f : cell.corner) f = offset + scale * dice.between(-1, 1);
  return cell;
}

TEST(TrilinearCell, corners_stand_in_the_order_of_the_paper) {
  TrilinearCell cell;
  for (std::size_t c = 0; c < 8; ++c) cell.corner[c] = static_cast<double>(c);
  EXPECT_EQ(cell.at({1, 0, 0}), 1);
  EXPECT_EQ(cell.at({0, 1, 0}), 2);
  EXPECT_EQ(cell.at({0, 0, 1}), 4);
  EXPECT_EQ(cell.at({1, 1, 1}), 7);
  EXPECT_EQ(cell.gradient({0.3, 0.6, 0.9}), Vec3(1, 2, 4));
}

TEST(TrilinearCell, interpolates_as_exact_arithmetic_does) {
  Dice dice(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const TrilinearCell cell = any_cell(dice);
    const Vec3 p = dice.point({0, 0, 0}, {1, 1, 1});
    EXPECT_NEAR(cell.at(p), rounded(exact_at(cell, exact(p))), 1e-15);
  }
}

TEST(TrilinearCell, gradient_is_the_exact_derivative) {
  Dice dice(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const TrilinearCell cell = any_cell(dice);
    const Vec3 p = dice.point({0, 0, 0}, {1, 1, 1});
    const Vec3 gradient = cell.gradient(p);
    for (int axis = 0; axis < 3; ++axis) {
      // Affine in each coordinate: the difference between opposite faces is the derivative.
      Vec3 low = p, high = p;
      low[axis] = 0;
      high[axis] = 1;
      const Rational derivative = exact_at(cell, exact(high)) - exact_at(cell, exact(low));
      EXPECT_NEAR(gradient[axis], rounded(derivative), 2e-15);
    }
  }
}

TEST(TrilinearCell, cubic_along_a_chord_is_the_exact_one) {
  Dice dice(3);
  for (int trial = 0; trial < 1500; ++trial) {
    const TrilinearCell cell = any_cell(dice);
    Vec3 p0 = dice.point({0, 0, 0}, {1, 1, 1}), p1 = dice.point({0, 0, 0}, {1, 1, 1});
    if (dice.below(3) == 0) p1[static_cast<int>(dice.below(3))] = 1;
    if (dice.below(5) == 0) p1 = p0 + 1e-9 * (p1 - p0);  // short chords
    const double iso = dice.between(-0.5, 0.5);
    const Cubic cubic = cell.along(p0, p1, iso);
    for (int i = 0; i <= 4; ++i) {
      const double s = i / 4.0;
      const ExactVec3 a = exact(p0), b = exact(p1);
      const Rational r = exact(s);
      const ExactVec3 p{a.x + r * (b.x - a.x), a.y + r * (b.y - a.y), a.z + r * (b.z - a.z)};
      EXPECT_NEAR(cubic.at(s).value, rounded(exact_at(cell, p) - exact(iso)), 4e-15);
    }
    EXPECT_NEAR(cubic.b[0], cell.at(p0) - iso, 1e-15);
    EXPECT_NEAR(cubic.b[3], cell.at(p1) - iso, 1e-15);
  }
}

// R27: with values of a million and differences of one, coefficients formed before the isovalue is
// subtracted lose half of their digits.
TEST(TrilinearCell, loses_nothing_to_a_large_offset_of_the_values) {
  Dice dice(4);
  for (int trial = 0; trial < 1000; ++trial) {
    TrilinearCell small, large;
    for (std::size_t c = 0; c < 8; ++c) {
      small.corner[c] = static_cast<double>(dice.below(2001) - 1000) / 1024;
      large.corner[c] = small.corner[c] + 1e6;
    }
    const Vec3 p0 = dice.point({0, 0, 0}, {1, 1, 1}), p1 = dice.point({0, 0, 0}, {1, 1, 1});
    EXPECT_EQ(small.along(p0, p1, 0.25).b, large.along(p0, p1, 1e6 + 0.25).b);
  }
}

// D03, D10: float can hold neither 32-bit integers nor the last digits of a double.
TEST(Differences, of_large_values_are_exact_in_float_and_keep_their_side) {
  Dice dice(8);
  for (int trial = 0; trial < 2000; ++trial) {
    const double isovalue = 4294967295.0 - static_cast<double>(dice.below(1000000));
    TrilinearCell cell;
    for (double& f : cell.corner) f = isovalue + static_cast<double>(dice.below(201) - 100) / 4;
    const auto [differences, unit] = render::minus<float>(cell, isovalue);
    EXPECT_EQ(unit, 1);
    for (std::size_t c = 0; c < 8; ++c)
      EXPECT_EQ(static_cast<double>(differences.corner[c]), cell.corner[c] - isovalue);
  }
}

TEST(Differences, keep_every_side_and_their_ratios_at_any_magnitude) {
  Dice dice(9);
  int beyond_float = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    TrilinearCell cell;
    const double scale = std::pow(10, dice.between(-300, 300));
    for (double& f : cell.corner) f = scale * dice.between(-1, 1) * std::pow(10, -dice.between(0, trial % 2 ? 2 : 80));
    const auto [differences, unit] = render::minus<float>(cell, 0);
    for (std::size_t c = 0; c < 8; ++c) {
      EXPECT_EQ(render::is_inside(differences.corner[c]), render::is_inside(cell.corner[c]));
      EXPECT_NEAR(static_cast<double>(differences.corner[c]), cell.corner[c] / unit,
                  6e-8 * std::abs(cell.corner[c] / unit) + 1e-44);
    }
    beyond_float += unit != 1;
  }
  EXPECT_GT(beyond_float, 3000);
  EXPECT_EQ(render::minus<float>(TrilinearCell{}, 0).unit, 1);
}

TEST(TrilinearCell, neighbours_agree_on_their_face_bit_for_bit) {
  Dice dice(5);
  for (int trial = 0; trial < 3000; ++trial) {
    const double magnitude = std::pow(10, dice.between(-30, 30));
    for (const std::size_t bit : {1U, 2U, 4U}) {
      const int axis = bit == 1 ? 0 : bit == 2 ? 1 : 2;
      const TrilinearCell low = any_cell(dice, 0, magnitude);
      TrilinearCell high = any_cell(dice, 0, magnitude * std::pow(10, dice.between(-5, 5)));
      for (std::size_t c = 0; c < 8; ++c)
        if (!(c & bit)) high.corner[c] = low.corner[c | bit];
      Vec3 on_low = dice.point({0, 0, 0}, {1, 1, 1}), on_high = on_low;
      on_low[axis] = 1;
      on_high[axis] = 0;
      const double iso = magnitude * dice.between(-1, 1);
      const Vec3 elsewhere = dice.point({0, 0, 0}, {1, 1, 1});
      EXPECT_EQ(low.at(on_low), high.at(on_high));
      EXPECT_EQ(low.along(elsewhere, on_low, iso).b[3], high.along(on_high, elsewhere, iso).b[0]);
      EXPECT_EQ(low.gradient(on_low)[(axis + 1) % 3], high.gradient(on_high)[(axis + 1) % 3]);
    }
  }
}

TEST(TrilinearCell, keeps_the_side_where_all_corners_agree) {
  Dice dice(6);
  for (int trial = 0; trial < 5000; ++trial) {
    TrilinearCell cell;
    const double iso = dice.between(-10, 10);
    const bool inside = dice.coin();
    for (double& f : cell.corner) {
      const double away = dice.below(3) == 0 ? 0 : std::pow(10, dice.between(-14, 3));
      f = inside ? iso + away : std::min(iso - away, std::nextafter(iso, -1e9));
    }
    const Vec3 p0 = dice.point({0, 0, 0}, {1, 1, 1}), p1 = dice.point({0, 0, 0}, {1, 1, 1});
    const Cubic cubic = cell.along(p0, p1, iso);
    for (const double b : cubic.b) EXPECT_EQ(render::is_inside(b), inside);
    EXPECT_EQ(first_change_of_side(cubic, inside), std::nullopt);
  }
}

TEST(TrilinearCell, of_equal_corners_is_exactly_zero_when_measured_from_them) {
  Dice dice(7);
  for (int trial = 0; trial < 1000; ++trial) {
    TrilinearCell cell;
    cell.corner.fill(dice.between(-1, 1));
    const Vec3 p0 = dice.point({0, 0, 0}, {1, 1, 1}), p1 = dice.point({0, 0, 0}, {1, 1, 1});
    for (const double b : cell.along(p0, p1, cell.corner[0]).b) EXPECT_EQ(b, 0);
  }
}

TEST(TrilinearCell, has_no_data_when_a_corner_is_not_finite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()})
    for (std::size_t c = 0; c < 8; ++c) {
      TrilinearCell cell{};
      EXPECT_TRUE(cell.has_data());
      cell.corner[c] = bad;
      EXPECT_FALSE(cell.has_data());
    }
}

TEST(TrilinearCell, knows_its_smallest_and_largest_corner) {
  EXPECT_EQ((TrilinearCell{{3, -1, 4, 1, -5, 9, 2, 6}}.smallest()), -5);
  EXPECT_EQ((TrilinearCell{{3, -1, 4, 1, -5, 9, 2, 6}}.largest()), 9);
}

}  // namespace
}  // namespace rhoray::tests
