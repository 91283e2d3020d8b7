#include "render/exact/exact_numbers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace rhoray::render::exact {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double largest = std::numeric_limits<double>::max();
constexpr double smallest = std::numeric_limits<double>::denorm_min();

TEST(ExactNumbers, round_outward_to_the_next_double) {
  const Rational third(1, 3);
  EXPECT_EQ(rounded_down(third), 1.0 / 3);  // 1/3 rounds down
  EXPECT_EQ(rounded_up(third), std::nextafter(1.0 / 3, 1));
  EXPECT_EQ(rounded_down(-third), -std::nextafter(1.0 / 3, 1));
  EXPECT_EQ(rounded_up(-third), -1.0 / 3);
}

TEST(ExactNumbers, keep_a_double_as_it_is) {
  for (const double x : {0.0, 1.0, -2.5, 1e300, -1e-300, smallest, -3 * smallest, largest, -largest}) {
    EXPECT_EQ(rounded_down(Rational(x)), x);
    EXPECT_EQ(rounded_up(Rational(x)), x);
  }
}

TEST(ExactNumbers, round_where_doubles_end) {
  const Rational beyond = Rational(largest) * 3, below = Rational(smallest) / 3;
  EXPECT_EQ(rounded_down(beyond), largest);
  EXPECT_EQ(rounded_up(beyond), infinity);
  EXPECT_EQ(rounded_down(-beyond), -infinity);
  EXPECT_EQ(rounded_up(-beyond), -largest);
  EXPECT_EQ(rounded_down(below), 0);
  EXPECT_EQ(rounded_up(below), smallest);
  EXPECT_EQ(rounded_down(-below), -smallest);
  EXPECT_EQ(rounded_up(-below), 0);
}

TEST(ExactNumbers, know_a_tight_enclosure) {
  EXPECT_TRUE(is_tight({1, 1}));
  EXPECT_TRUE(is_tight({1, std::nextafter(1, 2)}));
  EXPECT_FALSE(is_tight({1, 1 + 5e-16}));
}

TEST(ExactNumbers, measure_doubles_in_a_common_unit) {
  const double numbers[] = {3.0, -0.5, 0.0, 1e20, smallest, -1.0 / 3};
  const CommonUnit unit(numbers);
  for (const double x : numbers) EXPECT_EQ(Rational(unit.whole(x)) * power_of_two(unit.exponent()), Rational(x)) << x;
  EXPECT_EQ(unit.exponent(), -1074);
}

TEST(ExactNumbers, keep_small_numbers_small) {
  const double numbers[] = {6.0, 8.0, 0.0};
  const CommonUnit unit(numbers);
  EXPECT_EQ(unit.whole(6), 3);
  const double zeros[] = {0.0, -0.0};
  EXPECT_EQ(CommonUnit(zeros).whole(-0.0), 0);
}

}  // namespace
}  // namespace rhoray::render::exact
