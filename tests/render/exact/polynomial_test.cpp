#include "render/exact/polynomial.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/render/exact/sturm.h"

namespace rhoray::render::exact {
namespace {

/// c (t - r1) (t - r2) ... times the denominators.
Polynomial with_roots(const std::vector<Rational>& roots, int factor = 1) {
  Polynomial p{{Whole(factor), 0, 0, 0}};
  for (const Rational& root : roots) {
    Polynomial next;
    for (std::size_t k = 0; k < 4; ++k) {
      next.c[k] -= p.c[k] * numerator(root);
      if (k < 3) next.c[k + 1] += p.c[k] * denominator(root);
    }
    p = next;
  }
  return p;
}

std::vector<int> signs_of(const SignChart& chart) {
  std::vector<int> signs;
  for (const SignChart::Piece& piece : chart.pieces()) signs.push_back(piece.sign);
  return signs;
}

tests::Rational by_other_library(const Whole& x) {
  return tests::Rational(x.str());
}

tests::Coefficients coefficients_of(const Polynomial& p) {
  tests::Coefficients c;
  for (const Whole& coefficient : p.c) c.push_back(by_other_library(coefficient));
  return c;
}

TEST(Polynomial, knows_its_sign_and_value) {
  const Polynomial p{{-2, 0, 1, 0}};
  EXPECT_EQ(p.sign_at(Rational(7, 5)), -1);
  EXPECT_EQ(p.sign_at(Rational(3, 2)), 1);
  EXPECT_EQ(p.at(Rational(3, 2)), Rational(1, 4));
  EXPECT_EQ(p.above(Rational(1, 4)).sign_at(Rational(3, 2)), 0);
  EXPECT_EQ(p.above(Rational(1, 4)).sign_at(Rational(2)), 1);
  EXPECT_EQ(p.degree(), 2);
  EXPECT_EQ((Polynomial{}.degree()), -1);
}

TEST(SignChart, finds_three_rational_roots) {
  const SignChart chart(with_roots({Rational(1, 7), Rational(1, 2), Rational(5, 6)}), 0, 1);
  ASSERT_EQ(chart.roots().size(), 3);
  EXPECT_EQ(signs_of(chart), (std::vector{-1, 1, -1, 1}));
  const Enclosure first = chart.enclosing_root(0, 1e-30);
  EXPECT_LE(Rational(first.lo), Rational(1, 7));
  EXPECT_GE(Rational(first.hi), Rational(1, 7));
  EXPECT_TRUE(is_tight(first));
}

TEST(SignChart, leaves_out_roots_beyond_the_ends) {
  const SignChart chart(with_roots({Rational(-1), Rational(1, 3), Rational(2)}), 0, 1);
  ASSERT_EQ(chart.roots().size(), 1);
  EXPECT_EQ(signs_of(chart), (std::vector{1, -1}));
}

TEST(SignChart, finds_a_double_root_exactly) {
  const SignChart chart(with_roots({Rational(1, 3), Rational(1, 3), Rational(3, 4)}), 0, 1);
  ASSERT_EQ(chart.roots().size(), 2);
  EXPECT_TRUE(chart.roots()[0].is_exact());
  EXPECT_EQ(chart.roots()[0].lo, Rational(1, 3));
  EXPECT_EQ(signs_of(chart), (std::vector{-1, -1, 1}));
}

TEST(SignChart, tells_a_double_root_from_an_irrational_one_around_it) {
  // A double root in the middle of the interval in which the other is isolated.
  for (const Rational& other : {Rational(2, 5), Rational(3, 5), Rational(1, 2) + power_of_two(-100)}) {
    const SignChart chart(with_roots({Rational(1, 2), Rational(1, 2), other}), 0, 1);
    EXPECT_EQ(chart.roots().size(), 2);
  }
  EXPECT_EQ(signs_of(SignChart(with_roots({Rational(1, 2), Rational(1, 2), Rational(2, 5)}), 0, 1)),
            (std::vector{-1, 1, 1}));
}

TEST(SignChart, finds_a_double_root_of_a_parabola) {
  const SignChart chart(with_roots({Rational(2, 7), Rational(2, 7)}, -3), 0, 1);
  ASSERT_EQ(chart.roots().size(), 1);
  EXPECT_EQ(chart.roots()[0].lo, Rational(2, 7));
  EXPECT_EQ(signs_of(chart), (std::vector{-1, -1}));
}

TEST(SignChart, finds_a_triple_root_exactly) {
  const SignChart chart(with_roots({Rational(2, 3), Rational(2, 3), Rational(2, 3)}), 0, 1);
  ASSERT_EQ(chart.roots().size(), 1);
  EXPECT_EQ(chart.roots()[0].lo, Rational(2, 3));
  EXPECT_EQ(signs_of(chart), (std::vector{-1, 1}));
}

TEST(SignChart, counts_roots_at_both_ends) {
  const SignChart chart(with_roots({Rational(0), Rational(1), Rational(1)}), 0, 1);
  ASSERT_EQ(chart.roots().size(), 2);
  EXPECT_EQ(chart.roots()[0].lo, 0);
  EXPECT_EQ(chart.roots()[1].lo, 1);
  EXPECT_EQ(signs_of(chart), std::vector{1});
}

TEST(SignChart, encloses_an_irrational_root_as_narrowly_as_asked) {
  const SignChart chart(Polynomial{{-2, 0, 1, 0}}, 1, 2);
  ASSERT_EQ(chart.roots().size(), 1);
  for (const double width : {std::numeric_limits<double>::infinity(), 0.5, 1e-3, 1e-9, 1e-15, 1e-100, 1e-300, 0.0}) {
    const Enclosure root = chart.enclosing_root(0, width);
    EXPECT_LE(Rational(root.lo) * Rational(root.lo), 2);
    EXPECT_GE(Rational(root.hi) * Rational(root.hi), 2);
    EXPECT_TRUE(root.width() <= width || is_tight(root)) << width;
  }
}

/// The only double between its neighbours is the root itself, and no interval around it is tight.
/// The search for one did not terminate, for a ray 1e4 volumes away whose crossing was a double.
TEST(SignChart, encloses_a_root_that_is_a_double_more_narrowly_than_doubles_lie) {
  const double root = 1234 + 0x1.23456789p-9;
  const SignChart chart(with_roots({Rational(root), Rational(1, 3), Rational(-5, 7)}), 1000, 1500);
  ASSERT_EQ(chart.roots().size(), 1);
  const Enclosure found = chart.enclosing_root(0, 1e-17);
  EXPECT_TRUE(is_tight(found));
  EXPECT_TRUE(found.contains(root));
}

TEST(SignChart, tells_roots_apart_that_no_double_can) {
  const Rational gap = power_of_two(-200);
  const SignChart chart(with_roots({Rational(1, 3), Rational(1, 3) + gap, Rational(1, 3) + 3 * gap}), 0, 1);
  EXPECT_EQ(chart.roots().size(), 3);
  EXPECT_EQ(signs_of(chart), (std::vector{-1, 1, -1, 1}));
}

TEST(SignChart, sees_the_gap_where_a_parabola_all_but_touches) {
  Polynomial p = with_roots({Rational(1, 3), Rational(1, 3)});
  for (Whole& c : p.c) c <<= 300;
  p.c[0] += 1;
  EXPECT_TRUE(SignChart(p, 0, 1).roots().empty());
  p.c[0] -= 2;
  EXPECT_EQ(SignChart(p, 0, 1).roots().size(), 2);
}

TEST(SignChart, says_that_a_polynomial_is_zero_throughout) {
  const SignChart chart(Polynomial{}, 0, 1);
  EXPECT_TRUE(chart.is_zero_throughout());
  EXPECT_TRUE(chart.roots().empty());
  EXPECT_EQ(signs_of(chart), std::vector{0});
}

TEST(SignChart, knows_a_constant) {
  const SignChart chart(Polynomial{{-5, 0, 0, 0}}, 0, 1);
  EXPECT_TRUE(chart.roots().empty());
  EXPECT_EQ(signs_of(chart), std::vector{-1});
}

TEST(SignChart, has_no_pieces_at_a_point) {
  const SignChart chart(with_roots({Rational(1, 3)}), Rational(1, 3), Rational(1, 3));
  EXPECT_EQ(chart.roots().size(), 1);
  EXPECT_TRUE(chart.pieces().empty());
}

TEST(FirstChange, comes_from_outside_at_the_first_root) {
  const SignChart chart(with_roots({Rational(1, 4), Rational(1, 2)}, -1), 0, 1);
  const auto change = first_change(chart, false);
  ASSERT_TRUE(change.has_value());
  EXPECT_EQ(change->root, 0);
  EXPECT_FALSE(change->touches);
}

TEST(FirstChange, comes_from_inside_where_the_outside_begins) {
  // 0 at 1/4 without leaving, then it leaves at 1/2.
  const SignChart chart(with_roots({Rational(1, 4), Rational(1, 4), Rational(1, 2)}, -1), 0, 1);
  const auto change = first_change(chart, true);
  ASSERT_TRUE(change.has_value());
  EXPECT_EQ(change->root, 1);
}

TEST(FirstChange, flags_a_touch_from_outside_and_ignores_one_from_inside) {
  const SignChart outside(with_roots({Rational(1, 3), Rational(1, 3)}, -1), 0, 1);
  ASSERT_TRUE(first_change(outside, false).has_value());
  EXPECT_TRUE(first_change(outside, false)->touches);
  const SignChart inside(with_roots({Rational(1, 3), Rational(1, 3)}), 0, 1);
  EXPECT_FALSE(first_change(inside, true).has_value());
}

TEST(FirstChange, is_at_the_start_when_that_lies_on_the_other_side) {
  const SignChart chart(Polynomial{{1, 0, 0, 0}}, 0, 1);
  ASSERT_TRUE(first_change(chart, false).has_value());
  EXPECT_EQ(first_change(chart, false)->root, -1);
  EXPECT_FALSE(first_change(chart, true).has_value());
}

TEST(SignChart, agrees_with_sturm_on_small_polynomials) {
  int with_roots_inside = 0;
  for (int code = 0; code < 9 * 9 * 9 * 9; code += 7) {
    const Polynomial p{{code % 9 - 4, code / 9 % 9 - 4, code / 81 % 9 - 4, code / 729 - 4}};
    const SignChart chart(p, -1, Rational(3, 2));
    const tests::SturmChart sturm(coefficients_of(p), -1, tests::Rational(3, 2));
    ASSERT_EQ(chart.roots().size(), sturm.roots().size()) << code;
    with_roots_inside += !sturm.roots().empty();
    for (const bool starts_inside : {false, true}) {
      const auto ours = first_change(chart, starts_inside);
      const auto theirs = sturm.first_change(starts_inside);
      ASSERT_EQ(ours.has_value(), theirs.has_value()) << code;
      if (!ours) continue;
      ASSERT_EQ(ours->touches, theirs->touches) << code;
      const Enclosure at = chart.enclosing_root(ours->root, 1e-15);
      ASSERT_TRUE(tests::holds(at.lo, at.hi, theirs->at)) << code;
      ASSERT_TRUE(at.width() <= 1e-15 || is_tight(at)) << code;
    }
  }
  EXPECT_GT(with_roots_inside, 300);
}

}  // namespace
}  // namespace rhoray::render::exact
