#include "render/exact/exact_cell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/render/exact/exact_field.h"
#include "tests/render/support/rays.h"

namespace rhoray::render {
namespace {

using tests::Dice;
using tests::exact;

TrilinearCell cell_of(const std::function<double(double, double, double)>& f) {
  TrilinearCell cell{};
  for (std::size_t c = 0; c < 8; ++c) cell.corner[c] = f(c & 1 ? 1 : 0, c & 2 ? 1 : 0, c & 4 ? 1 : 0);
  return cell;
}

bool is_tight(const Enclosure& e) {
  return std::nextafter(e.lo, 2) >= e.hi;
}

constexpr Vec3 low{0, 0, 0}, high{1, 1, 1};
constexpr double width = 1e-14;

TEST(ExactCell, R01_a_plane_is_crossed_where_it_stands) {
  const TrilinearCell plane = cell_of([](double u, double v, double w) { return u + 2 * v + 4 * w; });
  const CellVerdict verdict = exact_crossing(plane, {0, 0.25, 0.5}, {1, 0.25 + 1e-17, 0.5}, 3, false, width);
  ASSERT_TRUE(verdict.changes);
  EXPECT_TRUE(verdict.s.contains(0.5));
  EXPECT_LE(verdict.s.width(), width);
  EXPECT_EQ(verdict.root_count, 1);
}

TEST(ExactCell, R02_a_bilinear_patch_is_crossed_twice) {
  // u (1 - v) + (1 - u) v along the diagonal: 2 s (1 - s) = 3/8 at 1/4 and 3/4.
  const TrilinearCell saddle = cell_of([](double u, double v, double) { return u * (1 - v) + (1 - u) * v; });
  const CellVerdict verdict = exact_crossing(saddle, low, {1, 1, 0}, 0.375, false, width);
  ASSERT_TRUE(verdict.changes);
  EXPECT_FALSE(verdict.touches);
  EXPECT_EQ(verdict.root_count, 2);
  EXPECT_TRUE(verdict.s.contains(0.25));
}

TEST(ExactCell, R03_a_linear_field_has_its_exact_root) {
  const TrilinearCell linear = cell_of([](double u, double, double) { return u; });
  const CellVerdict verdict = exact_crossing(linear, {0, 0.5, 0.5}, {1, 0.5, 0.5}, 1.0 / 3, false, width);
  EXPECT_TRUE(verdict.s.contains(1.0 / 3));
}

TEST(ExactCell, R04_a_constant_cell_has_no_surface) {
  const TrilinearCell constant = cell_of([](double, double, double) { return 7; });
  EXPECT_FALSE(exact_crossing(constant, low, high, 8, false, width).changes);
  EXPECT_FALSE(exact_crossing(constant, low, high, 6, true, width).changes);
}

TEST(ExactCell, R05_a_constant_cell_at_the_isovalue_is_inside) {
  const TrilinearCell constant = cell_of([](double, double, double) { return 7; });
  const CellVerdict from_outside = exact_crossing(constant, low, high, 7, false, width);
  ASSERT_TRUE(from_outside.changes);
  EXPECT_FALSE(from_outside.touches);
  EXPECT_EQ(from_outside.s.hi, 0);
  EXPECT_EQ(from_outside.root_count, -1);
  EXPECT_FALSE(exact_crossing(constant, low, high, 7, true, width).changes);
}

TEST(ExactCell, R06_a_double_root_touches) {
  const TrilinearCell saddle = cell_of([](double u, double v, double) { return u * (1 - v) + (1 - u) * v; });
  const CellVerdict verdict = exact_crossing(saddle, low, {1, 1, 0}, 0.5, false, width);
  ASSERT_TRUE(verdict.changes);
  EXPECT_TRUE(verdict.touches);
  EXPECT_EQ(verdict.root_count, 1);
  EXPECT_EQ(verdict.s.lo, 0.5);
  EXPECT_EQ(verdict.s.hi, 0.5);
  EXPECT_EQ(verdict.road, Road::exact);
}

TEST(ExactCell, R07_R08_one_ulp_decides_between_a_miss_and_two_roots) {
  const TrilinearCell saddle = cell_of([](double u, double v, double) { return u * (1 - v) + (1 - u) * v; });
  EXPECT_FALSE(exact_crossing(saddle, low, {1, 1, 0}, std::nextafter(0.5, 1), false, width).changes);
  const CellVerdict inside = exact_crossing(saddle, low, {1, 1, 0}, std::nextafter(0.5, 0), false, width);
  ASSERT_TRUE(inside.changes);
  EXPECT_EQ(inside.root_count, 2);
  EXPECT_FALSE(inside.touches);
  // 2 (s - 1/2)^2 = 2^-54
  EXPECT_NEAR(inside.s.lo, 0.5 - std::sqrt(0x1p-55), 1e-14);
}

TEST(ExactCell, R09_a_triple_root_is_crossed_once) {
  // (u - 1/2) (v - 1/2) (w - 1/2) along the diagonal
  const TrilinearCell cell = cell_of([](double u, double v, double w) { return (u - 0.5) * (v - 0.5) * (w - 0.5); });
  const CellVerdict verdict = exact_crossing(cell, low, high, 0, false, width);
  ASSERT_TRUE(verdict.changes);
  EXPECT_FALSE(verdict.touches);
  EXPECT_EQ(verdict.root_count, 1);
  EXPECT_EQ(verdict.s.lo, 0.5);
}

TEST(ExactCell, R10_of_three_roots_the_first_is_given) {
  // (u - 1/4) (v - 1/2) (w - 3/4) along the diagonal
  const TrilinearCell cell = cell_of([](double u, double v, double w) { return (u - 0.25) * (v - 0.5) * (w - 0.75); });
  const CellVerdict verdict = exact_crossing(cell, low, high, 0, false, width);
  EXPECT_EQ(verdict.root_count, 3);
  EXPECT_TRUE(verdict.s.contains(0.25));
  const std::vector<Enclosure> roots = exact_roots(cell, low, high, 0, width);
  ASSERT_EQ(roots.size(), 3);
  EXPECT_TRUE(roots[0].contains(0.25) && roots[1].contains(0.5) && roots[2].contains(0.75));
}

TEST(ExactCell, R11_two_roots_between_ends_on_one_side_are_seen) {
  // 4 u (1 - v) - 1/4 along the diagonal: both ends at -1/4, the middle above 0.
  const TrilinearCell cell = cell_of([](double u, double v, double) { return 4 * u * (1 - v) - 0.25; });
  const CellVerdict verdict = exact_crossing(cell, low, {1, 1, 0}, 0, false, width);
  EXPECT_EQ(verdict.root_count, 2);
  EXPECT_NEAR(verdict.s.lo, 0.5 - std::sqrt(3.0) / 4, 1e-14);
}

TEST(ExactCell, R12_R13_roots_at_the_ends_are_exact) {
  const TrilinearCell linear = cell_of([](double u, double, double) { return u; });
  const CellVerdict at_start = exact_crossing(linear, low, high, 0, false, width);
  EXPECT_TRUE(at_start.changes);
  EXPECT_FALSE(at_start.touches);
  EXPECT_EQ(at_start.s.hi, 0);
  const CellVerdict at_end = exact_crossing(linear, low, high, 1, false, width);
  EXPECT_TRUE(at_end.changes);
  EXPECT_TRUE(at_end.touches) << "what comes behind the cell is not this cell's to say";
  EXPECT_EQ(at_end.s.lo, 1);
  // From inside, the value 0 at the end is still inside.
  const TrilinearCell falling = cell_of([](double u, double, double) { return 1 - u; });
  EXPECT_FALSE(exact_crossing(falling, low, high, 0, true, width).changes);
  // A start at 0 on a falling field leaves at once.
  const CellVerdict leaves = exact_crossing(falling, low, high, 1, true, width);
  EXPECT_TRUE(leaves.changes);
  EXPECT_EQ(leaves.s.hi, 0);
}

TEST(ExactCell, R21_an_ambiguous_face_follows_the_trilinear_field) {
  const TrilinearCell alternating =
      cell_of([](double u, double v, double w) { return (2 * u - 1) * (2 * v - 1) * (2 * w - 1); });
  // On the face w = 1 the asymptotes cross in the middle: just beside it, the two connections are
  // distinguished.
  EXPECT_EQ(exact_crossing(alternating, {0, 0, 1}, {1, 1, 1}, 0, true, width).touches, false);
  EXPECT_FALSE(exact_crossing(alternating, {0, 0, 1}, {1, 1, 1}, 0, true, width).changes)
      << "0 at one point from inside";
  EXPECT_TRUE(exact_crossing(alternating, {0, 0, 1}, {1, 1, 1}, 1e-300, true, width).changes);
}

TEST(ExactCell, R22_the_saddle_in_the_body_decides_about_the_tunnel) {
  // Two opposite corners at 3, the others at -1: the value at the centre is 0.
  const TrilinearCell cell{{3, -1, -1, -1, -1, -1, -1, 3}};
  const tests::SturmChart through(tests::cubic_along(cell, low, high, 0), 0, 1);
  EXPECT_EQ(exact_crossing(cell, low, high, 0, true, width).changes, through.first_change(true).has_value());
  EXPECT_FALSE(exact_crossing(cell, low, high, 0, true, width).changes) << "the tunnel is open at one point";
  EXPECT_EQ(exact_crossing(cell, low, high, 0, true, width).root_count, 1);
  EXPECT_TRUE(exact_crossing(cell, low, high, 1e-300, true, width).changes);
  EXPECT_EQ(exact_crossing(cell, low, high, 1e-300, true, width).root_count, 2);
  EXPECT_FALSE(exact_crossing(cell, low, high, -1e-300, true, width).changes);
}

TEST(ExactCell, judges_a_chord_of_length_zero) {
  const TrilinearCell linear = cell_of([](double u, double, double) { return u; });
  const Vec3 p(0.5, 0.5, 0.5);
  const CellVerdict at_isovalue = exact_crossing(linear, p, p, 0.5, false, width);
  EXPECT_TRUE(at_isovalue.changes);
  EXPECT_EQ(at_isovalue.root_count, -1);
  EXPECT_FALSE(exact_crossing(linear, p, p, 0.5, true, width).changes);
  EXPECT_TRUE(exact_crossing(linear, p, p, 0.75, true, width).changes);
}

TEST(ExactCell, judges_a_start_on_the_other_side_at_once) {
  const TrilinearCell linear = cell_of([](double u, double, double) { return u; });
  const CellVerdict verdict = exact_crossing(linear, {0.5, 0, 0}, {1, 0, 0}, 0.25, false, width);
  EXPECT_TRUE(verdict.changes);
  EXPECT_EQ(verdict.s.hi, 0);
}

TEST(ExactCell, judges_values_at_the_ends_of_the_range_of_doubles) {
  const double largest = std::numeric_limits<double>::max(), smallest = std::numeric_limits<double>::denorm_min();
  const TrilinearCell huge = cell_of([&](double u, double, double) { return u > 0.5 ? largest : -largest; });
  EXPECT_TRUE(exact_crossing(huge, {0, 0, 0}, {1, 0, 0}, 0, false, width).s.contains(0.5));
  const TrilinearCell tiny = cell_of([&](double u, double, double) { return u > 0.5 ? smallest : -smallest; });
  EXPECT_TRUE(exact_crossing(tiny, {0, 0, 0}, {1, 0, 0}, 0, false, width).s.contains(0.5));
}

/// Cells and chords with many difficulties: any sizes, values on a lattice, a large offset,
/// tangent.
struct HardChord {
  TrilinearCell cell{};
  Vec3 p0, p1;
  double isovalue = 0;
};
HardChord hard_chord(Dice& dice) {
  HardChord hard;
  const std::int64_t kind = dice.below(7);
  for (double& f : hard.cell.corner) {
    f = dice.between(-1, 1);
    if (kind == 1) f = static_cast<double>(dice.below(5) - 2);
    if (kind == 2) f = 1e6 + f;
    if (kind == 3) f = std::ldexp(f, static_cast<int>(dice.below(60)) - 30);
  }
  hard.p0 = dice.point({0, 0, 0}, {1, 1, 1});
  hard.p1 = dice.point({0, 0, 0}, {1, 1, 1});
  const auto on_face = [&](Vec3& p) { p[static_cast<int>(dice.below(3))] = dice.coin() ? 0 : 1; };
  on_face(hard.p0);
  on_face(hard.p1);
  if (dice.below(4) == 0)
    for (int axis = 0; axis < 3; ++axis) hard.p0[axis] = std::round(2 * hard.p0[axis]) / 2;
  if (dice.below(4) == 0)
    for (int axis = 0; axis < 3; ++axis) hard.p1[axis] = std::round(2 * hard.p1[axis]) / 2;
  if (kind == 2) hard.isovalue = 1e6 + dice.between(-1, 1);
  if (kind == 0 || kind == 3) hard.isovalue = dice.between(-0.5, 0.5);
  if (kind == 6) {  // touches: b times 2 s (1 - s) along the diagonal, with its maximum at b / 2
    const double a = static_cast<double>(dice.below(9) - 4), b = static_cast<double>(1 + dice.below(5));
    hard.cell = cell_of([&](double u, double v, double) { return a + b * (u * (1 - v) + (1 - u) * v); });
    const double w = dice.between(0, 1);
    hard.p0 = {0, 0, w}, hard.p1 = {1, 1, w};
    hard.isovalue = a + b / 2;
  }
  if (kind == 4 || kind == 5) {
    const double top = exact_maximum(hard.cell, hard.p0, hard.p1, 1e-12).value.lo;
    hard.isovalue = kind == 4 ? top : std::nextafter(top, dice.coin() ? -2 : 2);
  }
  return hard;
}

TEST(ExactCell, gives_the_same_verdict_with_and_without_the_filter) {
  Dice dice(3);
  int filtered = 0, changed = 0, several = 0;
  for (int round = 0; round < 20000; ++round) {
    const HardChord hard = hard_chord(dice);
    const bool starts_inside = dice.coin();
    const CellVerdict quick = exact_crossing(hard.cell, hard.p0, hard.p1, hard.isovalue, starts_inside, width);
    const CellVerdict slow =
        exact_crossing_unfiltered(hard.cell, hard.p0, hard.p1, hard.isovalue, starts_inside, width);
    ASSERT_EQ(quick.changes, slow.changes) << round;
    ASSERT_EQ(quick.touches, slow.touches) << round;
    ASSERT_EQ(quick.root_count, slow.root_count) << round;
    ASSERT_TRUE(quick.s.lo <= slow.s.hi && quick.s.hi >= slow.s.lo) << round;
    ASSERT_TRUE(quick.s.width() <= width || is_tight(quick.s)) << round;
    ASSERT_TRUE(slow.s.width() <= width || is_tight(slow.s)) << round;
    filtered += quick.road == Road::filter;
    changed += quick.changes;
    several += quick.root_count > 1;
  }
  EXPECT_GT(filtered, 10000);
  EXPECT_LT(filtered, 29000) << "these are no longer hard";
  EXPECT_GT(changed, 8000);
  EXPECT_GT(several, 300);
}

TEST(ExactCell, agrees_with_sturms_theorem_on_numbers_of_another_library) {
  Dice dice(4);
  int changed = 0, touched = 0;
  for (int round = 0; round < 200; ++round) {
    const HardChord hard = hard_chord(dice);
    const bool starts_inside = dice.coin();
    const tests::SturmChart sturm(tests::cubic_along(hard.cell, hard.p0, hard.p1, hard.isovalue), 0, 1);
    const CellVerdict verdict = exact_crossing(hard.cell, hard.p0, hard.p1, hard.isovalue, starts_inside, width);
    const auto change = sturm.first_change(starts_inside);
    ASSERT_EQ(verdict.changes, change.has_value()) << round;
    ASSERT_EQ(verdict.root_count, sturm.is_zero() ? -1 : static_cast<int>(sturm.roots().size())) << round;
    if (!change) continue;
    ASSERT_EQ(verdict.touches, change->touches) << round;
    ASSERT_TRUE(tests::holds(verdict.s.lo, verdict.s.hi, change->at)) << round;
    ++changed;
    touched += change->touches;
  }
  EXPECT_GT(changed, 50);
  EXPECT_GT(touched, 5);
}

TEST(ExactCell, finds_the_papers_maximum_that_no_face_shows) {
  const TrilinearCell saddle = cell_of([](double u, double v, double) { return u * (1 - v) + (1 - u) * v; });
  const MaximumVerdict verdict = exact_maximum_unfiltered(saddle, low, {1, 1, 0}, width);
  EXPECT_EQ(verdict.value.lo, 0.5);
  EXPECT_EQ(verdict.value.hi, 0.5);
  EXPECT_EQ(verdict.s.lo, 0.5);
  EXPECT_EQ(verdict.s.hi, 0.5);
}

TEST(ExactCell, gives_the_first_of_equal_maxima) {
  const TrilinearCell constant = cell_of([](double, double, double) { return 3; });
  EXPECT_EQ(exact_maximum(constant, low, high, width).s.hi, 0);
  const TrilinearCell valley = cell_of([](double u, double v, double) { return (1 - u) * (1 - v) + u * v; });
  EXPECT_EQ(exact_maximum(valley, low, {1, 1, 0}, width).s.hi, 0);
}

TEST(ExactCell, gives_the_same_maximum_with_and_without_the_filter_and_none_above_it) {
  Dice dice(5);
  int filtered = 0, inside = 0;
  for (int round = 0; round < 10000; ++round) {
    const HardChord hard = hard_chord(dice);
    const MaximumVerdict quick = exact_maximum(hard.cell, hard.p0, hard.p1, width);
    const MaximumVerdict slow = exact_maximum_unfiltered(hard.cell, hard.p0, hard.p1, width);
    ASSERT_TRUE(quick.value.lo <= slow.value.hi && quick.value.hi >= slow.value.lo) << round;
    ASSERT_TRUE(quick.s.lo <= slow.s.hi && quick.s.hi >= slow.s.lo) << round;
    ASSERT_TRUE(quick.s.width() <= width || is_tight(quick.s)) << round;
    const double size = std::max(std::abs(hard.cell.smallest()), std::abs(hard.cell.largest()));
    ASSERT_LE(quick.value.width(), width * size) << round;
    filtered += quick.road == Road::filter;
    inside += slow.s.lo > 0 && slow.s.hi < 1;
    if (round % 50 != 0) continue;
    for (int k = 0; k <= 20; ++k) {
      const tests::Rational s = tests::Rational(k) / 20;
      ASSERT_LE(tests::field_at(hard.cell.corner, tests::on_chord(hard.p0, hard.p1, s)), exact(slow.value.hi)) << round;
    }
    // The value is reached: at the enclosure's middle it is smaller by no more than the curve can
    // bend there.
    const tests::Rational at = (exact(slow.s.lo) + exact(slow.s.hi)) / 2;
    const tests::Rational value = tests::field_at(hard.cell.corner, tests::on_chord(hard.p0, hard.p1, at));
    ASSERT_GE(tests::rounded(value - exact(slow.value.lo)), -1e-12 * size) << round;
  }
  EXPECT_GT(filtered, 4000);
  EXPECT_GT(inside, 1000);
}

}  // namespace
}  // namespace rhoray::render
