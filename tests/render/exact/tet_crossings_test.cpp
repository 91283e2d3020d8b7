#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "render/exact/exact_tets.h"
#include "tests/render/exact/tet_block.h"
#include "tests/render/support/exact.h"

namespace rhoray::render {
namespace {

using tests::Dice;
using tests::exact;
using tests::ExactVec3;
using tests::Rational;

constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

struct LinearInT {
  Rational at_0, slope;
  Rational at(const Rational& t) const { return at_0 + t * slope; }
};

/// The part of a ray in a tetrahedron, and value - isovalue along it.
struct Piece {
  Rational in, out;
  LinearInT excess;
  std::uint64_t id;

  bool holds(const Rational& t) const { return in <= t && t <= out; }
};

/// By Cramer's rule at two points of the ray. Nothing where the ray has no length in the
/// tetrahedron.
std::optional<Piece> piece_of(const ExactTet& tet, const Ray& ray, double isovalue) {
  const ExactVec3 p0 = exact(tet.point[0]), d = exact(ray.direction);
  const ExactVec3 a = exact(tet.point[1]) - p0, b = exact(tet.point[2]) - p0, c = exact(tet.point[3]) - p0;
  const ExactVec3 q = exact(ray.origin) - p0;
  const Rational volume = a.dot(b.cross(c));
  if (volume == 0) return std::nullopt;
  const auto weights_of = [&](const ExactVec3& x) {
    return std::array<Rational, 3>{x.dot(b.cross(c)) / volume, a.dot(x.cross(c)) / volume, a.dot(b.cross(x)) / volume};
  };
  const std::array<Rational, 3> start = weights_of(q), step = weights_of(d);
  std::array<LinearInT, 4> weight{{{1, 0}, {start[0], step[0]}, {start[1], step[1]}, {start[2], step[2]}}};
  for (std::size_t i = 1; i < 4; ++i) {
    weight[0].at_0 -= weight[i].at_0;
    weight[0].slope -= weight[i].slope;
  }
  Piece piece{exact(std::max(ray.t_min, -1e300)), exact(std::min(ray.t_max, 1e300)), {-exact(isovalue), 0}, tet.id};
  for (std::size_t i = 0; i < 4; ++i) {
    piece.excess.at_0 += weight[i].at_0 * exact(tet.value[i]);
    piece.excess.slope += weight[i].slope * exact(tet.value[i]);
    if (weight[i].slope == 0 && weight[i].at_0 < 0) return std::nullopt;
    if (weight[i].slope == 0) continue;
    const Rational passed = -weight[i].at_0 / weight[i].slope;
    if (weight[i].slope > 0) piece.in = std::max(piece.in, passed);
    if (weight[i].slope < 0) piece.out = std::min(piece.out, passed);
  }
  if (piece.in >= piece.out) return std::nullopt;
  return piece;
}

struct TrueCrossing {
  Rational t;
  std::uint64_t cell;
  bool to_inside;
};

/// Tests all points at which a side may change, and a point between each two of them.
std::vector<TrueCrossing> crossings_by_brute_force(const std::vector<ExactTet>& tets, const Ray& ray, double isovalue) {
  std::vector<Piece> pieces;
  std::vector<Rational> points;
  for (const ExactTet& tet : tets) {
    const auto piece = piece_of(tet, ray, isovalue);
    if (!piece) continue;
    pieces.push_back(*piece);
    points.insert(points.end(), {piece->in, piece->out});
    if (piece->excess.slope == 0) continue;
    const Rational zero = -piece->excess.at_0 / piece->excess.slope;
    if (piece->holds(zero)) points.push_back(zero);
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::sort(pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return a.in != b.in ? a.in < b.in : a.id < b.id; });

  // Nothing between the tetrahedra.
  const auto side_at = [&](const Rational& t) {
    std::optional<bool> side;
    for (const Piece& piece : pieces) {
      if (!piece.holds(t)) continue;
      const bool here = piece.excess.at(t) >= 0;
      EXPECT_EQ(side.value_or(here), here) << "the mesh is no partition";
      side = here;
    }
    return side;
  };
  // The first piece, by in and id, with the point and a side there or right behind it.
  const auto cell_of = [&](const Rational& point, const Rational& shows) {
    for (const Piece& piece : pieces)
      if (piece.holds(point) && piece.holds(shows)) return piece.id;
    return all;
  };
  std::vector<TrueCrossing> crossings;
  std::optional<bool> side;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::optional<bool> here = side_at(points[p]);
    if (side && here && *side != *here) {
      EXPECT_TRUE(*here) << "the field is not continuous";
      crossings.push_back({points[p], cell_of(points[p], points[p]), true});
    }
    if (p + 1 == points.size()) break;
    const Rational between = (points[p] + points[p + 1]) / 2;
    side = side_at(between);
    if (side && here && *side != *here) {
      EXPECT_TRUE(*here) << "the field is not continuous";
      crossings.push_back({points[p], cell_of(points[p], between), false});
    }
  }
  return crossings;
}

struct Stress {
  std::vector<ExactTet> tets;
  Ray ray;
  double isovalue;
  double width;

  std::vector<TetCrossing> crossings(std::size_t most = all) const {
    return exact_crossings(tets, ray, isovalue, width, most);
  }
  TetRayVerdict first() const { return exact_first_crossing(tets, ray, isovalue, width); }
};

/// A mesh of any kind, and a ray through its cells, faces, edges and vertices.
/// @param edge  of the mesh, in cubes of six tetrahedra
Stress any_stress(Dice& dice, int edge = 3) {
  const bool whole_values = dice.below(3) > 0;
  const Vec3 at = dice.one_of(std::array{Vec3(0, 0, 0), Vec3(1e3, -1e3, 5), Vec3(148376, 1234, -223423)});
  Stress made{.tets = tests::block(edge, dice, dice.coin() ? 0 : 0.15, at, whole_values),
              .ray = {},
              .isovalue = whole_values ? static_cast<double>(dice.below(4) - 1) : dice.between(-0.5, 0.5),
              .width = dice.coin() ? 1e-13 : 1e-6};
  made.ray = tests::aimed_ray(made.tets, dice);
  if (dice.below(4) == 0) made.ray.t_max = dice.between(8, 10);
  if (dice.below(4) == 0)  // gaps
    std::erase_if(made.tets, [](const ExactTet& tet) { return tet.id % 7 == 2; });
  return made;
}

bool are_equal(const TetCrossing& a, const TetCrossing& b) {
  return a.t.lo == b.t.lo && a.t.hi == b.t.hi && a.cell == b.cell && a.to_inside == b.to_inside;
}

TEST(ExactTetCrossings, agree_with_brute_force) {
  Dice dice(41);
  int found = 0, touches = 0, many = 0, on_exact_road = 0, on_filter_road = 0;
  for (int round = 0; round < 900; ++round) {
    const Stress stress = any_stress(dice, 2);
    const auto crossings = stress.crossings();
    const auto expected = crossings_by_brute_force(stress.tets, stress.ray, stress.isovalue);
    ASSERT_EQ(crossings.size(), expected.size()) << round;
    const Road road = stress.first().road;
    if (crossings.size() > 1) ++(road == Road::exact ? on_exact_road : on_filter_road);
    many += crossings.size() > 2;
    for (std::size_t c = 0; c < crossings.size(); ++c) {
      const TetCrossing& crossing = crossings[c];
      ++found;
      ASSERT_EQ(crossing.to_inside, expected[c].to_inside) << round << " " << c;
      ASSERT_TRUE(exact(crossing.t.lo) <= expected[c].t && expected[c].t <= exact(crossing.t.hi)) << round << " " << c;
      ASSERT_EQ(crossing.cell, expected[c].cell) << round << " " << c;
      ASSERT_TRUE(crossing.t.width() <= stress.width ||
                  std::nextafter(crossing.t.lo, std::numeric_limits<double>::infinity()) >= crossing.t.hi);
      if (c == 0) continue;
      ASSERT_TRUE(crossing.t.lo >= crossings[c - 1].t.lo && crossing.t.hi >= crossings[c - 1].t.hi) << round;
      if (expected[c].t != expected[c - 1].t) continue;
      ++touches;
      ASSERT_TRUE(crossing.t.lo == crossings[c - 1].t.lo && crossing.t.hi == crossings[c - 1].t.hi) << round;
    }
  }
  EXPECT_GT(found, 400);
  EXPECT_GT(many, 15);
  EXPECT_GT(touches, 5);
  EXPECT_GT(on_exact_road, 30);
  EXPECT_GT(on_filter_road, 20);
}

TEST(ExactTetCrossings, begin_with_the_first_crossing) {
  Dice dice(42);
  int hits = 0, touches = 0;
  for (int round = 0; round < 1500; ++round) {
    const Stress stress = any_stress(dice);
    const TetRayVerdict first = stress.first();
    const auto crossings = stress.crossings();
    ASSERT_EQ(first.is_hit, !crossings.empty()) << round;
    if (!first.is_hit) continue;
    ++hits;
    touches += first.touches;
    ASSERT_TRUE(crossings[0].t.lo == first.t.lo && crossings[0].t.hi == first.t.hi) << round;
    ASSERT_EQ(crossings[0].cell, first.cell) << round;
    ASSERT_TRUE(!first.touches || crossings[0].to_inside) << round;
    for (std::size_t most = 0; most <= crossings.size(); ++most) {
      const auto some = stress.crossings(most);
      ASSERT_EQ(some.size(), most) << round;
      for (std::size_t c = 0; c < most; ++c) ASSERT_TRUE(are_equal(some[c], crossings[c])) << round;
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(touches, 10);
}

TEST(ExactTetCrossings, are_the_same_from_cells_that_reach_the_isovalue_alone) {
  Dice dice(43);
  std::size_t found = 0;
  for (int round = 0; round < 1500; ++round) {
    Stress stress = any_stress(dice);
    const auto from_all = stress.crossings();
    // Other cells are then like gaps, so this holds for meshes without gaps.
    if (stress.tets.size() < 6 * 27) continue;
    std::erase_if(stress.tets, [&](const ExactTet& tet) {
      const auto [least, most] = std::minmax({tet.value[0], tet.value[1], tet.value[2], tet.value[3]});
      return least > stress.isovalue || most < stress.isovalue;
    });
    const auto from_closed = stress.crossings();
    ASSERT_EQ(from_all.size(), from_closed.size()) << round;
    for (std::size_t c = 0; c < from_all.size(); ++c) {
      ASSERT_TRUE(from_all[c].t.lo <= from_closed[c].t.hi && from_all[c].t.hi >= from_closed[c].t.lo) << round;
      ASSERT_EQ(from_all[c].to_inside, from_closed[c].to_inside) << round;
      ASSERT_EQ(from_all[c].to_inside, from_all[0].to_inside == (c % 2 == 0)) << round << ": sides alternate";
    }
    found += from_all.size();
  }
  EXPECT_GT(found, 1000U);
}

TEST(ExactTetCrossings, do_not_depend_on_the_order_of_cells) {
  Dice dice(44);
  for (int round = 0; round < 300; ++round) {
    Stress stress = any_stress(dice);
    const auto forth = stress.crossings();
    std::reverse(stress.tets.begin(), stress.tets.end());
    const auto back = stress.crossings();
    ASSERT_EQ(forth.size(), back.size()) << round;
    for (std::size_t c = 0; c < forth.size(); ++c) ASSERT_TRUE(are_equal(forth[c], back[c])) << round;
  }
}

constexpr double width = 1e-13;

/// Two tetrahedra on both sides of the face x = 0, whose vertices have value 0 and the far ones the
/// given values.
std::array<ExactTet, 2> two_sides(double before, double behind) {
  const Vec3 a(0, 0, 0), b(0, 1, 0), c(0, 0, 1);
  return {ExactTet{{Vec3(-1, 0.2, 0.2), a, b, c}, {before, 0, 0, 0}, 7},
          ExactTet{{a, b, c, Vec3(1, 0.2, 0.2)}, {0, 0, 0, behind}, 3}};
}

TEST(ExactTetCrossings, cross_touch_or_leave_a_face_at_the_isovalue) {
  const Ray ray{{-2, 0.2, 0.2}, {1, 0, 0}};
  const auto found = [&](double before, double behind, const Ray& through) {
    return exact_crossings(two_sides(before, behind), through, 0, width, all);
  };
  const auto is_at_face = [](const TetCrossing& crossing) { return crossing.t.lo == 2 && crossing.t.hi == 2; };
  const auto crossed = found(-1, 1, ray);
  ASSERT_EQ(crossed.size(), 1U);
  EXPECT_TRUE(is_at_face(crossed[0]) && crossed[0].to_inside && crossed[0].cell == 7);
  const auto touched = found(-1, -1, ray);
  ASSERT_EQ(touched.size(), 2U);
  EXPECT_TRUE(is_at_face(touched[0]) && touched[0].to_inside && touched[0].cell == 7);
  EXPECT_TRUE(is_at_face(touched[1]) && !touched[1].to_inside && touched[1].cell == 3);
  const auto left = found(1, -1, ray);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_TRUE(is_at_face(left[0]) && !left[0].to_inside && left[0].cell == 3);
  EXPECT_TRUE(found(1, 1, ray).empty());
  EXPECT_EQ(found(-1, -1, {ray.origin, ray.direction, 0, 2}).size(), 1U) << "nothing shows what follows";
  EXPECT_TRUE(found(0, 0, ray).empty()) << "at the isovalue everywhere, so inside";
}

TEST(ExactTetCrossings, come_to_an_end_where_cells_overlap_and_disagree) {
  Dice dice(45);
  int disagreements = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<ExactTet> tets = tests::block(1, dice, 0, {0, 0, 0}, true);
    const auto other = tests::block(1, dice, dice.coin() ? 0 : 0.15, {0, 0, 0}, true);
    tets.insert(tets.end(), other.begin(), other.end());
    const Ray ray = tests::aimed_ray(tets, dice);
    const TetRayVerdict first = exact_first_crossing(tets, ray, 0, width);
    const auto crossings = exact_crossings(tets, ray, 0, width, all);
    ASSERT_EQ(first.is_hit, !crossings.empty()) << round;
    if (!first.is_hit) continue;
    ASSERT_TRUE(crossings[0].t.lo == first.t.lo && crossings[0].cell == first.cell) << round;
    for (std::size_t c = 1; c < crossings.size(); ++c) {
      ASSERT_NE(crossings[c].to_inside, crossings[c - 1].to_inside) << round;
      ASSERT_GE(crossings[c].t.lo, crossings[c - 1].t.lo) << round;
    }
    disagreements += crossings.size() > 6;
  }
  EXPECT_GT(disagreements, 0);
}

TEST(ExactTetCrossings, are_none_for_what_is_no_ray_or_no_number) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto tets = two_sides(-1, 1);
  const Ray ray{{-2, 0.2, 0.2}, {1, 0, 0}};
  for (const Ray& none : {Ray{ray.origin, {0, 0, 0}}, Ray{{-1, 0.1, std::nan("")}, {1, 0, 0}},
                          Ray{ray.origin, ray.direction, infinity}, Ray{ray.origin, ray.direction, 2, 1}})
    EXPECT_TRUE(exact_crossings(tets, none, 0, width, all).empty());
  EXPECT_TRUE(exact_crossings(tets, ray, std::nan(""), width, all).empty());
  EXPECT_EQ(exact_crossings(tets, ray, 0, width, all).size(), 1U);
}

}  // namespace
}  // namespace rhoray::render
