#include "formats/base/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace rhoray {
namespace {

TEST(NumberText, rounds_up_to_what_is_not_smaller) {
  EXPECT_EQ(rounded_up(0, 2), "0");
  EXPECT_EQ(rounded_up(1.04, 2), "1.1");
  EXPECT_EQ(rounded_up(1.06, 2), "1.1");
  EXPECT_EQ(rounded_up(0.001, 2), "0.001");
  EXPECT_EQ(rounded_up(9.94, 2), "11");
  std::mt19937_64 random(26);
  std::uniform_real_distribution<double> exponent(-30, 30);
  for (int i = 0; i < 10'000; ++i) {
    const double number = std::pow(10, exponent(random));
    const double up = std::strtod(rounded_up(number, 2).c_str(), nullptr);
    EXPECT_GE(up, number);
    EXPECT_LE(up, 1.12 * number);
  }
}

TEST(NumberText, prints_as_many_digits_as_the_error_leaves) {
  EXPECT_EQ(text_with_error(2.0 / 3, 0.01, "mm"), "0.6667 mm, error at most 0.011 mm");
  EXPECT_EQ(text_with_error(2.0 / 3, 1e-9, ""), "0.6666666667, error at most 1.1e-09");
  EXPECT_EQ(text_with_error(6, 0, "mm"), "6 mm, error at most 0 mm");
  EXPECT_EQ(text_with_error(1.0 / 3, 0, ""), "0.3333333333333333, error at most 0");
}

}  // namespace
}  // namespace rhoray
