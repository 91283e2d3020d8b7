#include "render/exact/ball.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/exact/cubic_filter.h"
#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::render {
namespace {

using tests::exact;
using tests::Rational;

bool holds(const Ball& ball, const Rational& x) {
  return abs(Rational(x - exact(ball.middle))) <= exact(ball.radius);
}

/// A number of any magnitude, half of the time an integer times a power of two.
double any_number(tests::Dice& dice) {
  const double x = dice.coin() ? dice.between(-1, 1) : static_cast<double>(dice.below(9) - 4);
  return std::ldexp(x, static_cast<int>(dice.below(200)) - 100);
}

struct Known {
  Ball ball;
  Rational truth;  ///< at an end of the ball or inside
};
Known any_ball(tests::Dice& dice) {
  const double middle = any_number(dice), radius = dice.coin() ? 0 : std::abs(any_number(dice));
  const int where = static_cast<int>(dice.below(3)) - 1;
  return {{middle, radius}, exact(middle) + exact(radius) * where};
}

TEST(Ball, holds_the_result_of_every_operation) {
  tests::Dice dice(1);
  int divided = 0;
  for (int round = 0; round < 20000; ++round) {
    const Known a = any_ball(dice), b = any_ball(dice);
    ASSERT_TRUE(holds(a.ball + b.ball, a.truth + b.truth));
    ASSERT_TRUE(holds(a.ball - b.ball, a.truth - b.truth));
    ASSERT_TRUE(holds(a.ball * b.ball, a.truth * b.truth));
    const Ball quotient = a.ball / b.ball;
    if (!std::isfinite(quotient.radius)) continue;
    ++divided;
    ASSERT_TRUE(holds(quotient, a.truth / b.truth));
  }
  EXPECT_GT(divided, 5000);
}

TEST(Ball, holds_the_value_between_two_others) {
  tests::Dice dice(2);
  for (int round = 0; round < 20000; ++round) {
    const Known a = any_ball(dice), b = any_ball(dice);
    const double w = dice.one_of(std::array{0.0, 1.0, dice.between(0, 1), 0x1p-60, 1 - 0x1p-53});
    const Rational truth = std::min(std::max(exact(w) + exact(dice.between(-0.01, 0.01)), Rational(0)), Rational(1));
    const double radius = std::nextafter(std::abs(tests::rounded(truth - exact(w))), 1);
    const Known weight = dice.coin() ? Known{{w, 0}, exact(w)} : Known{{w, radius}, truth};
    ASSERT_TRUE(holds(between(a.ball, b.ball, weight.ball), (1 - weight.truth) * a.truth + weight.truth * b.truth));
  }
}

TEST(Ball, is_certain_of_nothing_after_an_overflow) {
  const Ball large{1e308, 0};
  EXPECT_EQ((large + large).sign(), 0);
  EXPECT_EQ((large * large).sign(), 0);
  EXPECT_EQ((large + large - large).sign(), 0);
  EXPECT_EQ((large / Ball{0, 0}).sign(), 0);
  EXPECT_EQ(along({-1e308, 1e308, 1e308, 1e308, 1e308, 1e308, 1e308, 1e308}, 1.5e308, {}, {}).b[0].sign(), 0);
}

TEST(Ball, stays_narrow) {
  const Ball third = Ball{1} / Ball{3};
  EXPECT_LT(third.radius, 3e-16);
  EXPECT_LT((third * Ball{3} - Ball{1}).radius, 2e-15);
}

TEST(BallCubic, restricted_to_a_part_starts_and_ends_there) {
  const BallCubic cubic{{Ball{1}, Ball{-3}, Ball{4}, Ball{2}}};
  const BallCubic part = cubic.on(0.25, 0.75);
  EXPECT_NEAR(part.b[0].middle, cubic.at(0.25).middle, 1e-15);
  EXPECT_NEAR(part.b[3].middle, cubic.at(0.75).middle, 1e-15);
  EXPECT_NEAR(part.at(0.5).middle, cubic.at(0.5).middle, 1e-15);
}

TEST(CertainRoots, counts_three_and_encloses_the_first) {
  // Bernstein coefficients of (s - 0.1) (s - 0.5) (s - 0.9).
  const BallCubic cubic{{Ball{-0.045}, Ball{0.59 / 3 - 0.045}, Ball{1.18 / 3 - 0.5 - 0.045}, Ball{0.045}}};
  const auto roots = certain_roots(cubic, 1e-10);
  ASSERT_TRUE(roots.has_value());
  EXPECT_EQ(roots->count, 3);
  EXPECT_EQ(roots->sign_at_0, -1);
  EXPECT_LE(roots->first.width(), 1e-10);
  EXPECT_NEAR(roots->first.lo, 0.1, 1e-10);
}

TEST(CertainRoots, says_nothing_where_two_more_roots_may_be) {
  const Ball unknown{0, 5};
  EXPECT_FALSE(certain_roots({{Ball{-1}, unknown, unknown, Ball{1}}}, 1e-3).has_value());
  const auto one = certain_roots({{Ball{-1}, Ball{-1}, unknown, Ball{1}}}, 1e-3);
  ASSERT_TRUE(one.has_value()) << "one change of sign, whatever the coefficient in doubt";
  EXPECT_EQ(one->count, 1);
}

TEST(CertainRoots, says_nothing_where_one_coefficient_in_doubt_may_make_two_roots) {
  const Ball one{1}, unknown{1, 5};
  EXPECT_FALSE(certain_roots({{one, one, unknown, one}}, 1e-3).has_value());
  EXPECT_FALSE(certain_roots({{one, unknown, one, one}}, 1e-3).has_value());
}

TEST(CertainRoots, says_nothing_of_a_touch) {
  // -(s - 1/2)^2.
  const BallCubic cubic{{Ball{-0.25}, Ball{1.0 / 12}, Ball{1.0 / 12}, Ball{-0.25}}};
  EXPECT_FALSE(certain_roots(cubic, 1e-10).has_value());
}

}  // namespace
}  // namespace rhoray::render
