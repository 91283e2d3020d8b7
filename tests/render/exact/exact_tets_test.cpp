#include "render/exact/exact_tets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/render/exact/tet_block.h"
#include "tests/render/support/exact.h"

namespace rhoray::render {
namespace {

using tests::aimed_ray;
using tests::block;
using tests::Dice;
using tests::exact;
using tests::ExactVec3;
using tests::Rational;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double width = 1e-13;

bool is_tight(const Enclosure& e) {
  return std::nextafter(e.lo, infinity) >= e.hi;
}

ExactTet corner_tet(std::array<double, 4> values, std::uint64_t id = 0) {
  return {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, values, id};
}

TEST(ExactTetsAlongRay, crosses_a_plane_where_it_stands) {
  const std::array tets{corner_tet({0, 1, 0, 0})};
  const TetRayVerdict verdict = exact_first_crossing(tets, {{-1, 0.1, 0.1}, {1, 0, 0}}, 1.0 / 3, width);
  ASSERT_TRUE(verdict.is_hit);
  EXPECT_LE(verdict.t.width(), width);
  EXPECT_TRUE(verdict.t.contains(4.0 / 3));
  EXPECT_EQ(verdict.road, Road::filter);
}

TEST(ExactTetsAlongRay, T17_sees_nothing_where_the_field_is_flat_along_the_ray) {
  const std::array tets{corner_tet({0, 0, 1, 0})};
  const Ray ray{{-1, 0.25, 0.1}, {1, 0, 0}};
  EXPECT_FALSE(exact_first_crossing(tets, ray, 0.3, width).is_hit);
  EXPECT_FALSE(exact_first_crossing(tets, ray, 0.2, width).is_hit) << "inside from the start";
  EXPECT_FALSE(exact_first_crossing(tets, ray, 0.25, width).is_hit) << "at the isovalue, so inside";
}

TEST(ExactTetsAlongRay, T22_sees_no_surface_where_the_mesh_begins) {
  const std::array tets{corner_tet({2, 2, 2, 2})};
  EXPECT_FALSE(exact_first_crossing(tets, {{-1, 0.1, 0.1}, {1, 0, 0}}, 1, width).is_hit);
}

TEST(ExactTetsAlongRay, forgets_its_side_in_a_gap) {
  ExactTet far = corner_tet({2, 2, 2, 2}, 1);
  for (Vec3& p : far.point) p.x += 3;
  const std::array tets{corner_tet({0, 0, 0, 0}), far};
  EXPECT_FALSE(exact_first_crossing(tets, {{-1, 0.1, 0.1}, {1, 0, 0}}, 1, width).is_hit);
}

/// Two tetrahedra on both sides of the face x = 0, whose vertices have value 0 and the far ones the
/// given values.
std::array<ExactTet, 2> two_sides(double before, double behind) {
  const Vec3 a(0, 0, 0), b(0, 1, 0), c(0, 0, 1);
  return {ExactTet{{Vec3(-1, 0.2, 0.2), a, b, c}, {before, 0, 0, 0}, 7},
          ExactTet{{a, b, c, Vec3(1, 0.2, 0.2)}, {0, 0, 0, behind}, 3}};
}

TEST(ExactTetsAlongRay, T15_a_face_at_the_isovalue_is_crossed_once_touched_or_left) {
  const Ray ray{{-2, 0.2, 0.2}, {1, 0, 0}};
  const TetRayVerdict crossed = exact_first_crossing(two_sides(-1, 1), ray, 0, width);
  ASSERT_TRUE(crossed.is_hit);
  EXPECT_FALSE(crossed.touches);
  EXPECT_EQ(crossed.t.lo, 2);
  EXPECT_EQ(crossed.t.hi, 2);
  EXPECT_EQ(crossed.cell, 7) << "the one that the ray enters first";
  const TetRayVerdict touched = exact_first_crossing(two_sides(-1, -1), ray, 0, width);
  EXPECT_TRUE(touched.is_hit && touched.touches);
  const TetRayVerdict left = exact_first_crossing(two_sides(1, -1), ray, 0, width);
  EXPECT_TRUE(left.is_hit && !left.touches);
  EXPECT_EQ(left.cell, 3);
  EXPECT_FALSE(exact_first_crossing(two_sides(1, 1), ray, 0, width).is_hit);
}

TEST(ExactTetsAlongRay, T08_T10_cells_without_volume_change_nothing) {
  auto two = two_sides(-1, 1);
  std::vector<ExactTet> tets(two.begin(), two.end());
  const Ray ray{{-2, 0.2, 0.2}, {1, 0, 0}};
  const TetRayVerdict without = exact_first_crossing(tets, ray, 0.5, width);
  tets.push_back({{Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0.3, 0.3)}, {0, 0, 0, 1}, 8});
  tets.push_back({{Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 1), Vec3(0, 1, 0)}, {0, 9, 0, 0}, 9});
  tets.push_back({{Vec3(-9, 0.2, 0.2), Vec3(0, 0.2, 0.2), Vec3(5, 0.2, 0.2), Vec3(8, 0.2, 0.2)}, {9, -9, 9, 9}, 10});
  const TetRayVerdict with = exact_first_crossing(tets, ray, 0.5, width);
  EXPECT_EQ(with.is_hit, without.is_hit);
  EXPECT_EQ(with.cell, without.cell);
  EXPECT_TRUE(with.t.lo <= without.t.hi && with.t.hi >= without.t.lo);
}

TEST(ExactTetsAlongRay, T11_an_inverted_cell_is_like_its_twin) {
  ExactTet tet = corner_tet({0, 1, 0, 0});
  std::swap(tet.point[0], tet.point[1]);
  std::swap(tet.value[0], tet.value[1]);
  EXPECT_TRUE(exact_first_crossing(std::array{tet}, {{-1, 0.1, 0.1}, {1, 0, 0}}, 0.25, width).t.contains(1.25));
}

TEST(ExactTetsAlongRay, T26_cells_that_are_not_finite_are_absent) {
  ExactTet tet = corner_tet({0, std::nan(""), 0, 0});
  EXPECT_FALSE(exact_first_crossing(std::array{tet}, {{-1, 0.1, 0.1}, {1, 0, 0}}, 0.25, width).is_hit);
  EXPECT_FALSE(exact_largest_value(std::array{tet}, {{-1, 0.1, 0.1}, {1, 0, 0}}).has_value);
  tet = corner_tet({0, 1, 0, 0});
  tet.point[2].y = infinity;
  EXPECT_FALSE(exact_first_crossing(std::array{tet}, {{-1, 0.1, 0.1}, {1, 0, 0}}, 0.25, width).is_hit);
}

TEST(ExactTetsAlongRay, T28_starts_on_the_side_where_the_ray_starts) {
  const std::array tets{corner_tet({0, 1, 0, 0})};
  EXPECT_FALSE(exact_first_crossing(tets, {{0.5, 0.1, 0.1}, {1, 0, 0}}, 0.5, width).is_hit) << "on the surface: inside";
  const TetRayVerdict leaves = exact_first_crossing(tets, {{0.5, 0.1, 0.1}, {-1, 0, 0}}, 0.5, width);
  EXPECT_TRUE(leaves.is_hit);
  EXPECT_EQ(leaves.t.hi, 0);
  const TetRayVerdict later = exact_first_crossing(tets, {{0.25, 0.1, 0.1}, {1, 0, 0}}, 0.5, width);
  EXPECT_TRUE(later.t.contains(0.25));
  EXPECT_FALSE(exact_first_crossing(tets, {{0.25, 0.1, 0.1}, {1, 0, 0}, 0, 0.125}, 0.5, width).is_hit);
}

TEST(ExactTetsAlongRay, refuses_what_is_no_ray) {
  const std::array tets{corner_tet({0, 1, 0, 0})};
  for (const Ray& ray : {Ray{{-1, 0.1, 0.1}, {0, 0, 0}}, Ray{{-1, 0.1, std::nan("")}, {1, 0, 0}},
                         Ray{{-1, 0.1, 0.1}, {1, 0, 0}, infinity}, Ray{{-1, 0.1, 0.1}, {1, 0, 0}, 2, 1}})
    EXPECT_FALSE(exact_first_crossing(tets, ray, 0.5, width).is_hit);
}

/// Returns value - isovalue in a tetrahedron at a point of the ray, by Cramer's rule. Returns
/// nothing outside the tetrahedron and for one without volume.
std::optional<Rational> value_in(const ExactTet& tet, const ExactVec3& x) {
  const ExactVec3 p0 = exact(tet.point[0]);
  const ExactVec3 a = exact(tet.point[1]) - p0, b = exact(tet.point[2]) - p0, c = exact(tet.point[3]) - p0, q = x - p0;
  const Rational volume = a.dot(b.cross(c));
  if (volume == 0) return std::nullopt;
  const Rational u = q.dot(b.cross(c)) / volume, v = a.dot(q.cross(c)) / volume, w = a.dot(b.cross(q)) / volume;
  const Rational rest = 1 - u - v - w;
  if (u < 0 || v < 0 || w < 0 || rest < 0) return std::nullopt;
  return rest * exact(tet.value[0]) + u * exact(tet.value[1]) + v * exact(tet.value[2]) + w * exact(tet.value[3]);
}

/// False for a tetrahedron that is far from a point, whatever the rounding.
bool may_hold(const ExactTet& tet, const Vec3& x) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto [least, most] =
        std::minmax({tet.point[0][axis], tet.point[1][axis], tet.point[2][axis], tet.point[3][axis]});
    if (x[axis] < least - 1e-3 || x[axis] > most + 1e-3) return false;
  }
  return true;
}

/// Returns the values of a mesh at a point of the ray.
std::vector<Rational> values_at(const std::vector<ExactTet>& tets, const Ray& ray, const Rational& t) {
  const ExactVec3 o = exact(ray.origin), d = exact(ray.direction);
  const ExactVec3 x{o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
  const Vec3 near_x(tests::rounded(x.x), tests::rounded(x.y), tests::rounded(x.z));
  std::vector<Rational> values;
  for (const ExactTet& tet : tets)
    if (may_hold(tet, near_x))
      if (const auto value = value_in(tet, x)) values.push_back(*value);
  return values;
}

TEST(ExactTetsAlongRay, says_what_is_true_at_points_of_the_ray) {
  Dice dice(21);
  int hits = 0, exact_road = 0, before = 0;
  for (int round = 0; round < 80; ++round) {
    const bool whole_values = dice.coin();
    const Vec3 at = dice.one_of(std::array{Vec3(0, 0, 0), Vec3(1e3, -1e3, 5), Vec3(148376, 1234, -223423)});
    const auto tets = block(2, dice, dice.coin() ? 0 : 0.15, at, whole_values);
    const double isovalue = whole_values ? static_cast<double>(dice.below(3) - 1) : dice.between(-0.5, 0.5);
    const Ray ray = aimed_ray(tets, dice);
    const TetRayVerdict verdict = exact_first_crossing(tets, ray, isovalue, width);
    exact_road += verdict.road == Road::exact;
    hits += verdict.is_hit;
    // The convex block has no gaps along a ray: the side before the crossing is the same
    // everywhere.
    const double end = verdict.is_hit ? verdict.t.lo : ray.t_min + 20;
    std::optional<bool> side;
    for (int k = 0; k < 20; ++k) {
      const double t = ray.t_min + (end - ray.t_min) * (0.5 + k) / 20;
      if (!(t < end)) continue;
      for (const Rational& value : values_at(tets, ray, exact(t))) {
        const bool here = value >= exact(isovalue);
        ASSERT_EQ(side.value_or(here), here) << round << " at " << t;
        side = here;
        ++before;
      }
    }
    if (!verdict.is_hit) continue;
    ASSERT_TRUE(verdict.t.width() <= width || is_tight(verdict.t)) << round;
    // The isovalue is between the values at both ends of the enclosure, if these are in the mesh.
    const auto lo = values_at(tets, ray, exact(verdict.t.lo)), hi = values_at(tets, ray, exact(verdict.t.hi));
    if (!lo.empty() && !hi.empty() && verdict.t.lo < verdict.t.hi && !verdict.touches) {
      ASSERT_LE((lo[0] - exact(isovalue)) * (hi[0] - exact(isovalue)), 0) << round;
    }
    if (verdict.t.lo == verdict.t.hi) {
      ASSERT_FALSE(lo.empty()) << round;
      ASSERT_TRUE(lo[0] == exact(isovalue)) << round;
    }
  }
  EXPECT_GT(hits, 20);
  EXPECT_GT(exact_road, 15);
  EXPECT_LT(exact_road, 75);
  EXPECT_GT(before, 150);
}

TEST(ExactTetsAlongRay, gives_the_same_verdict_from_active_cells_alone) {
  Dice dice(22);
  int hits = 0, only_touch_differs = 0;
  for (int round = 0; round < 1500; ++round) {
    const bool whole_values = dice.coin();
    const auto tets = block(2, dice, dice.coin() ? 0 : 0.15, {0, 0, 0}, whole_values);
    const double isovalue = whole_values ? static_cast<double>(dice.below(3) - 1) : dice.between(-0.5, 0.5);
    const Ray ray = aimed_ray(tets, dice);
    std::vector<ExactTet> active, closed;
    for (const ExactTet& tet : tets) {
      const auto [least, most] = std::minmax({tet.value[0], tet.value[1], tet.value[2], tet.value[3]});
      if (least < isovalue && most >= isovalue) active.push_back(tet);
      if (least <= isovalue && most >= isovalue) closed.push_back(tet);
    }
    const TetRayVerdict all = exact_first_crossing(tets, ray, isovalue, width);
    const TetRayVerdict of_active = exact_first_crossing(active, ray, isovalue, width);
    const TetRayVerdict of_closed = exact_first_crossing(closed, ray, isovalue, width);
    for (const TetRayVerdict& some : {of_active, of_closed}) {
      ASSERT_EQ(all.is_hit, some.is_hit) << round;
      ASSERT_TRUE(all.t.lo <= some.t.hi && all.t.hi >= some.t.lo) << round;
    }
    ASSERT_EQ(all.touches, of_closed.touches) << round;
    hits += all.is_hit;
    only_touch_differs += all.touches != of_active.touches;
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(only_touch_differs, 0) << "the docstring's exception is no longer met";
}

TEST(ExactTetsAlongRay, does_not_depend_on_the_order_of_cells) {
  Dice dice(23);
  for (int round = 0; round < 200; ++round) {
    auto tets = block(2, dice, dice.coin() ? 0 : 0.15, {0, 0, 0}, true);
    const Ray ray = aimed_ray(tets, dice);
    const TetRayVerdict forth = exact_first_crossing(tets, ray, 0, width);
    const TetMaximumVerdict top = exact_largest_value(tets, ray);
    std::reverse(tets.begin(), tets.end());
    const TetRayVerdict back = exact_first_crossing(tets, ray, 0, width);
    ASSERT_EQ(forth.is_hit, back.is_hit);
    ASSERT_EQ(forth.t.lo, back.t.lo);
    ASSERT_EQ(forth.cell, back.cell);
    ASSERT_EQ(forth.touches, back.touches);
    const TetMaximumVerdict top_back = exact_largest_value(tets, ray);
    ASSERT_EQ(top.value.lo, top_back.value.lo);
    ASSERT_EQ(top.t.lo, top_back.t.lo);
    ASSERT_EQ(top.cell, top_back.cell);
  }
}

TEST(ExactTetsAlongRay, finds_a_largest_value_that_is_reached_and_not_passed) {
  Dice dice(24);
  int found = 0;
  for (int round = 0; round < 30; ++round) {
    const auto tets = block(2, dice, dice.coin() ? 0 : 0.15, {0, 0, 0}, dice.coin());
    const Ray ray = aimed_ray(tets, dice);
    const TetMaximumVerdict verdict = exact_largest_value(tets, ray);
    if (!verdict.has_value) continue;
    ++found;
    ASSERT_TRUE(is_tight(verdict.value) && is_tight(verdict.t)) << round;
    for (int k = 0; k < 20; ++k)
      for (const Rational& value : values_at(tets, ray, exact(ray.t_min + k)))
        ASSERT_LE(value, exact(verdict.value.hi)) << round;
    for (const Rational& value : values_at(tets, ray, exact(verdict.t.lo)))
      ASSERT_NEAR(tests::rounded(value), verdict.value.lo, 1e-11) << round;
  }
  EXPECT_GT(found, 20);
}

}  // namespace
}  // namespace rhoray::render
