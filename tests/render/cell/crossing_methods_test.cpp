#include "render/cell/crossing_methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "render/cell/certified_crossing.h"
#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::CellCrossing;
using render::CellPassage;
using render::certify_crossing;
using render::closed_form_roots;
using render::CrossingMethod;
using render::Decision;
using render::eqn_eps;
using render::expanded_at_origin;
using render::find_crossing;
using render::PowerCubic;
using render::TrilinearCell;

/// A ray that passes through the cell [0, 1]^3.
CellPassage way_through(const Vec3& target, const Vec3& direction, double distance) {
  CellPassage way{{}, {}, target - distance * direction, direction, -1e300, 1e300};
  int axis_in = 0, axis_out = 0;
  for (int a = 0; a < 3; ++a) {
    if (direction[a] == 0) continue;
    const double low = (0 - way.origin[a]) / direction[a], high = (1 - way.origin[a]) / direction[a];
    if (std::min(low, high) > way.t_in) way.t_in = std::min(low, high), axis_in = a;
    if (std::max(low, high) < way.t_out) way.t_out = std::max(low, high), axis_out = a;
  }
  const auto point = [&](double t, int axis, bool is_in) {
    Vec3 p = way.origin + t * direction;
    for (int a = 0; a < 3; ++a) p[a] = std::clamp(p[a], 0.0, 1.0);
    p[axis] = (direction[axis] > 0) == is_in ? 0 : 1;
    return p;
  };
  way.in = point(way.t_in, axis_in, true), way.out = point(way.t_out, axis_out, false);
  return way;
}

TrilinearCell any_cell(Dice& dice, double offset = 0, double scale = 1) {
  TrilinearCell cell;
  for (double& f : cell.corner) f = offset + scale * dice.between(-1, 1);
  return cell;
}

template <class Real>
class CrossingMethods : public testing::Test {
 public:
  static constexpr bool is_float = std::is_same_v<Real, float>;
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(CrossingMethods, Reals);

TYPED_TEST(CrossingMethods, solve_cubics_in_closed_form) {
  const auto roots_of = [](TypeParam a, TypeParam b, TypeParam c, TypeParam d) {
    const auto roots = closed_form_roots(PowerCubic<TypeParam>{a, b, c, d});
    std::vector<double> sorted(roots.t.begin(), roots.t.begin() + roots.count);
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  const auto expect = [](const std::vector<double>& found, const std::vector<double>& roots) {
    ASSERT_EQ(found.size(), roots.size());
    for (std::size_t i = 0; i < roots.size(); ++i)
      EXPECT_NEAR(found[i], roots[i], (std::is_same_v<TypeParam, float> ? 4e-6 : 1e-14));
  };
  expect(roots_of(1, -6, 11, -6), {1, 2, 3});
  expect(roots_of(-2, 12, -22, 12), {1, 2, 3});
  expect(roots_of(1, 0, 1, -2), {1});
  expect(roots_of(1, -3, 3, -1), {1});
  expect(roots_of(1, 0, -3, 2), {-2, 1});  // (t - 1)^2 (t + 2)
  expect(roots_of(0, 1, -3, 2), {1, 2});
  expect(roots_of(0, 1, -2, 1), {1});
  expect(roots_of(0, 1, 0, 1), {});
  expect(roots_of(0, 0, 2, -1), {0.5});
  expect(roots_of(0, 0, 0, 1), {});
  expect(roots_of(0, 0, 0, 0), {});
  expect(roots_of(TypeParam(0.9) * TypeParam(eqn_eps), 0, 2, -1), {0.5});
}

TYPED_TEST(CrossingMethods, expand_the_cubic_at_the_origin_of_the_ray) {
  Dice dice(1);
  for (int trial = 0; trial < 300; ++trial) {
    const TrilinearCell cell = any_cell(dice);
    const double isovalue = dice.between(-0.5, 0.5);
    const CellPassage way = way_through(dice.point({0, 0, 0}, {1, 1, 1}), dice.direction(), 1.5);
    const PowerCubic<TypeParam> f = expanded_at_origin<TypeParam>(cell, way.origin, way.direction, isovalue);
    for (const double s : {0.0, 0.3, 1.0}) {
      const double t = (1 - s) * way.t_in + s * way.t_out;
      const double value =
          ((static_cast<double>(f.a) * t + static_cast<double>(f.b)) * t + static_cast<double>(f.c)) * t +
          static_cast<double>(f.d);
      EXPECT_NEAR(value, cell.at(way.origin + t * way.direction) - isovalue, (this->is_float ? 2e-4 : 4e-13));
    }
  }
}

/// How often a method is wrong, compared with the certified results in double.
struct Wrong {
  int crossings = 0, lost = 0, invented = 0, displaced = 0;
  double iterations = 0;
};

struct Case {
  TrilinearCell cell;
  CellPassage way;
  double isovalue;
};

/// @param tolerance  maximum distance of s from the truth, in addition to the truth's own bound
template <class Real>
Wrong wrong_answers(CrossingMethod method, const std::function<Case(Dice&)>& make, double tolerance,
                    int trials = 20000) {
  Dice dice(2);
  Wrong wrong;
  for (int trial = 0; trial < trials; ++trial) {
    const auto [cell, way, isovalue] = make(dice);
    const std::optional<bool> side = render::certain_side<double>(cell, way.in, 0, isovalue);
    if (!side) continue;
    const auto truth = certify_crossing<double>(cell, way.in, way.out, 0, isovalue, *side);
    if (truth.decision == Decision::unknown) continue;
    const CellCrossing found = find_crossing<Real>(method, cell, way, isovalue, *side);
    const bool crosses = truth.decision == Decision::crosses;
    wrong.crossings += crosses;
    wrong.lost += crosses && !found.crosses;
    wrong.invented += !crosses && found.crosses;
    wrong.displaced += crosses && found.crosses && std::abs(found.s - truth.s) > tolerance + truth.s_error;
    wrong.iterations += crosses ? found.iterations : 0;
  }
  return wrong;
}

Case ordinary(Dice& d) {
  return {any_cell(d), way_through(d.point({0, 0, 0}, {1, 1, 1}), d.direction(), 2), d.between(-0.5, 0.5)};
}
/// R01: the leading coefficient is nearly zero.
Case nearly_axis_parallel(Dice& d) {
  Vec3 direction;
  for (int a = 0; a < 3; ++a) direction[a] = d.between(-1, 1) * std::pow(10, d.between(-9, -5));
  direction[static_cast<int>(d.below(3))] = 1;
  return {any_cell(d), way_through(d.point({0, 0, 0}, {1, 1, 1}), direction, 2), d.between(-0.5, 0.5)};
}
/// R27: large values with small differences.
Case around_a_million(Dice& d) {
  Case c = ordinary(d);
  for (double& f : c.cell.corner) f += 1e6;
  c.isovalue += 1e6;
  return c;
}
/// R28: the eye is far away.
Case from_afar(Dice& d) {
  return {any_cell(d), way_through(d.point({0, 0, 0}, {1, 1, 1}), d.direction(), 1000), d.between(-0.5, 0.5)};
}
Case around_a_million_from_afar(Dice& d) {
  Case c = from_afar(d);
  for (double& f : c.cell.corner) f += 1e6;
  c.isovalue += 1e6;
  return c;
}

TYPED_TEST(CrossingMethods, bracketed_finds_what_is_there_in_ordinary_and_in_hard_cells) {
  for (const auto& make : {ordinary, nearly_axis_parallel, around_a_million, from_afar, around_a_million_from_afar}) {
    const Wrong wrong = wrong_answers<TypeParam>(CrossingMethod::bracketed, make, this->is_float ? 1e-3 : 1e-12);
    EXPECT_GT(wrong.crossings, 4000);
    // Only cells that are nearly tangent may be wrong in float.
    EXPECT_LE(wrong.lost + wrong.invented, this->is_float ? 2 : 0);
    EXPECT_LE(wrong.displaced, this->is_float ? 2 : 0);
    EXPECT_LT(wrong.iterations, (this->is_float ? 5 : 6) * wrong.crossings);
  }
}

TYPED_TEST(CrossingMethods, paper_is_right_close_by_and_wrong_where_the_catalogue_says) {
  const auto count = [&](const auto& make) {
    return wrong_answers<TypeParam>(CrossingMethod::paper, make, this->is_float ? 1e-2 : 1e-8);
  };
  const Wrong close_by = count(ordinary), axis_parallel = count(nearly_axis_parallel),
              million = count(around_a_million), afar = count(from_afar), both = count(around_a_million_from_afar);
  EXPECT_LT(close_by.lost + close_by.invented + close_by.displaced, this->is_float ? close_by.crossings / 50 : 20);
  EXPECT_GT(axis_parallel.lost + axis_parallel.displaced, this->is_float ? axis_parallel.crossings / 10 : 0) << "R01";
  EXPECT_GT(both.lost + both.displaced, both.crossings / 100) << "R27 and R28";
  if (this->is_float) {
    EXPECT_GT(million.lost, million.crossings / 100) << "R27";
    EXPECT_GT(afar.lost, afar.crossings / 10) << "R28";
  }
}

TYPED_TEST(CrossingMethods, preview_passes_by_what_lies_between_ends_on_one_side) {
  Dice dice(3);
  int passed_by = 0, found = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const auto [cell, way, isovalue] = ordinary(dice);
    const render::Cubic cubic = cell.along(way.in, way.out, isovalue);
    const bool starts_inside = render::is_inside(cubic.b[0]), ends_inside = render::is_inside(cubic.b[3]);
    if (std::min(std::abs(cubic.b[0]), std::abs(cubic.b[3])) < 1e-5) continue;
    const CellCrossing preview = find_crossing<TypeParam>(CrossingMethod::preview, cell, way, isovalue, starts_inside);
    const CellCrossing exact = find_crossing<double>(CrossingMethod::bracketed, cell, way, isovalue, starts_inside);
    ASSERT_EQ(preview.crosses, starts_inside != ends_inside);
    if (preview.crosses) {
      EXPECT_NEAR(preview.s, cubic.b[0] / (cubic.b[0] - cubic.b[3]), (this->is_float ? 3e-2 : 1e-9));
      ++found;
    }
    passed_by += exact.crosses && !preview.crosses;
  }
  EXPECT_GT(found, 3000);
  EXPECT_GT(passed_by, 100) << "R11";
}

TYPED_TEST(CrossingMethods, preview_and_bracketed_change_at_the_start_when_the_ray_comes_from_the_other_side) {
  const TrilinearCell cell{{1, 2, 1, 2, 1, 2, 1, 2}};
  const CellPassage way = way_through({0.5, 0.5, 0.5}, {1, 0, 0}, 2);
  for (const CrossingMethod method : {CrossingMethod::preview, CrossingMethod::bracketed}) {
    const CellCrossing found = find_crossing<TypeParam>(method, cell, way, 0.5, false);
    EXPECT_TRUE(found.crosses);
    EXPECT_EQ(found.s, 0);
    EXPECT_FALSE(find_crossing<TypeParam>(method, cell, way, 0.5, true).crosses);
  }
}

TYPED_TEST(CrossingMethods, bracketed_counts_the_crossings_of_the_cell) {
  // (u - 1/4)(v - 1/2)(w - 3/4) along u = v = w.
  TrilinearCell cell;
  for (std::size_t c = 0; c < 8; ++c)
    cell.corner[c] = (c & 1 ? 0.75 : -0.25) * (c & 2 ? 0.5 : -0.5) * (c & 4 ? 0.25 : -0.75);
  const CellPassage way = way_through({0.5, 0.5, 0.5}, {1, 1, 1}, 2);
  for (const CrossingMethod method : {CrossingMethod::bracketed, CrossingMethod::paper}) {
    const CellCrossing found = find_crossing<TypeParam>(method, cell, way, 0, false);
    EXPECT_EQ(found.root_count, 3);
    EXPECT_NEAR(found.s, 0.25, (this->is_float ? 1e-5 : 1e-12));
  }
  EXPECT_EQ(find_crossing<TypeParam>(CrossingMethod::bracketed, cell, way, -0.1, true).root_count, 0);
}

TYPED_TEST(CrossingMethods, bracketed_does_not_depend_on_the_unit_of_the_values) {
  Dice dice(4);
  for (int trial = 0; trial < 5000; ++trial) {
    const auto [cell, way, isovalue] = ordinary(dice);
    const bool starts_inside = dice.coin();
    const CellCrossing found = find_crossing<TypeParam>(CrossingMethod::bracketed, cell, way, isovalue, starts_inside);
    TrilinearCell scaled = cell;
    const int power = static_cast<int>(dice.below(1800)) - 900;
    for (double& f : scaled.corner) f = std::ldexp(f, power);
    const CellCrossing again =
        find_crossing<TypeParam>(CrossingMethod::bracketed, scaled, way, std::ldexp(isovalue, power), starts_inside);
    EXPECT_EQ(found.crosses, again.crosses);
    EXPECT_EQ(found.s, again.s) << power;
  }
}

}  // namespace
}  // namespace rhoray::tests
