#include "render/exact/maximum.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rhoray::render::exact {
namespace {

TEST(Surd, is_compared_exactly) {
  const Surd root2{0, 1, 2}, root8_halved{0, Rational(1, 2), 8}, one_and_root2{1, 1, 2}, root6{0, 1, 6};
  EXPECT_EQ(compare(root2, root8_halved), 0);
  EXPECT_EQ(compare(one_and_root2, root6), -1);
  EXPECT_EQ(compare(root6, one_and_root2), 1);
  EXPECT_EQ(compare(Surd{3, -1, 2}, Surd{0, 1, 3}), -1);
  EXPECT_EQ(compare(Surd{2, 0, 7}, Surd{0, 1, 4}), 0);
  EXPECT_EQ(compare(Surd{-5, 1, 2}, Surd{-5, -1, 3}), 1);
}

TEST(Surd, is_compared_where_doubles_are_equal) {
  // Convergents of sqrt(2): p^2 - 2 q^2 = +-1.
  const Rational above("1136689/803760"), below("470832/332929");
  EXPECT_EQ(compare(Surd{0, 1, 2}, Surd{above, 0, 0}), -1);
  EXPECT_EQ(compare(Surd{0, 1, 2}, Surd{below, 0, 0}), 1);
  const Surd shifted{power_of_two(-200), 1, 2};
  EXPECT_EQ(compare(shifted, Surd{0, 1, 2}), 1);
}

TEST(Surd, is_enclosed_tightly_whatever_cancels) {
  const Enclosure root2 = enclosing(Surd{0, 1, 2}, 0);
  EXPECT_TRUE(is_tight(root2));
  EXPECT_TRUE(root2.contains(std::sqrt(2.0)));
  // sqrt(n^2 + 1) - n = 1/(2 n) - ...
  const Rational n = power_of_two(300);
  const Enclosure small = enclosing(Surd{-n, 1, n * n + 1}, 0);
  EXPECT_TRUE(is_tight(small));
  EXPECT_TRUE(small.contains(0x1p-301) || small.hi == 0x1p-301);
}

TEST(Maximum, of_a_parabola_is_at_its_vertex) {
  const Maximum top = largest_value(Polynomial{{0, 1, -1, 0}}, 0, 1, 1e-12);  // t (1 - t)
  EXPECT_EQ(compare(top.value, {Rational(1, 4), 0, 0}), 0);
  EXPECT_EQ(top.at.lo, 0.5);
  EXPECT_EQ(top.at.hi, 0.5);
}

TEST(Maximum, inside_is_found_for_both_signs_of_the_leading_coefficient) {
  for (const int sign : {1, -1}) {
    // derivative sign * (t - r1) (t - r2) with irrational roots: 3 t^2 - 3 t + 1/2, times 2
    const Polynomial p{{0, sign * 1, sign * -3, sign * 2}};
    const Maximum top = largest_value(p, 0, 1, 1e-14);
    const double r = sign > 0 ? (3 - std::sqrt(3.0)) / 6 : (3 + std::sqrt(3.0)) / 6;
    EXPECT_NEAR(top.at.lo, r, 1e-13);
    EXPECT_NEAR(enclosing(top.value, 0).lo, std::sqrt(3.0) / 18, 1e-15);
  }
}

TEST(Maximum, at_an_end_counts_once_and_first) {
  // 0 at both ends, less between.
  EXPECT_EQ(largest_value(Polynomial{{0, -1, 1, 0}}, 0, 1, 1e-12).at.hi, 0);
  EXPECT_EQ(largest_value(Polynomial{{3, 1, 0, 0}}, 0, 1, 1e-12).at.lo, 1);
  EXPECT_EQ(largest_value(Polynomial{{3, 0, 0, 0}}, 0, 1, 1e-12).at.hi, 0);
}

TEST(Maximum, reached_inside_and_at_the_end_is_given_inside) {
  // (t - 1/4)^2 (t - 1), at most 0: there at 1/4 and at 1.
  const Maximum top = largest_value(Polynomial{{-1, 9, -24, 16}}, 0, 1, 1e-12);
  EXPECT_EQ(top.at.lo, 0.25);
  EXPECT_EQ(compare(top.value, {0, 0, 0}), 0);
}

}  // namespace
}  // namespace rhoray::render::exact
