#include "formats/base/floating_point.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/host_floating_point.h"

namespace rhoray::tests {

namespace {

/// Operations that the compiler can neither evaluate nor move.
double product(double a, double b) {
  volatile double x = a, y = b;
  volatile double out = x * y;
  return out;
}
double sum(double a, double b) {
  volatile double x = a, y = b;
  volatile double out = x + y;
  return out;
}

constexpr double smallest = std::numeric_limits<double>::denorm_min(), least = std::numeric_limits<double>::min();

bool is_default() {
  const bool keeps_results = product(least, 0.5) == 0x1p-1023, keeps_operands = product(smallest, 0x1p1023) > 0;
  const bool is_to_nearest = sum(1, 0x1p-53) == 1 && sum(1, 0x1.8p-53) > 1 && sum(-1, -0x1p-53) == -1;
  return keeps_results && keeps_operands && is_to_nearest && std::fegetround() == FE_TONEAREST;
}

}  // namespace

TEST(DefaultFloatingPoint, is_set_whatever_the_host_has_and_gives_that_back) {
  ASSERT_TRUE(is_default());
  for (const HostFloatingPoint& environment : host_environments()) {
    const InHostFloatingPoint host(environment);
    ASSERT_TRUE(host.is_kept()) << environment.name;
    EXPECT_FALSE(is_default()) << environment.name << " is not another environment";
    {
      const DefaultFloatingPoint outer;
      EXPECT_TRUE(is_default()) << environment.name;
      {
        const DefaultFloatingPoint inner;
        EXPECT_TRUE(is_default()) << environment.name;
      }
      EXPECT_TRUE(is_default()) << environment.name;
    }
    EXPECT_TRUE(host.is_kept()) << environment.name;
  }
}

TEST(DefaultFloatingPoint, raises_no_flag_that_the_caller_sees_and_clears_none) {
  std::feclearexcept(FE_ALL_EXCEPT);
  {
    const DefaultFloatingPoint guard;
    sum(1, 0x1p-60);
    product(least, least);
    ASSERT_TRUE(std::fetestexcept(FE_INEXACT) != 0 && std::fetestexcept(FE_UNDERFLOW) != 0);
  }
  EXPECT_EQ(std::fetestexcept(FE_ALL_EXCEPT), 0);
  std::feraiseexcept(FE_DIVBYZERO);
  {
    const DefaultFloatingPoint guard;
    EXPECT_EQ(std::fetestexcept(FE_ALL_EXCEPT), 0);
  }
  EXPECT_EQ(std::fetestexcept(FE_ALL_EXCEPT), FE_DIVBYZERO);
  std::feclearexcept(FE_ALL_EXCEPT);
}

}  // namespace rhoray::tests
