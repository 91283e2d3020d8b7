#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/exact/exact_grid.h"
#include "tests/render/exact/chords.h"

namespace rhoray::render {
namespace {

using tests::Dice;
using tests::ExactChord;
using tests::Rational;
using tests::TestGrid;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double width = 1e-13;
constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

/// A point of a ray, or an open piece between two of them.
struct Station {
  bool is_point;
  tests::SturmChart::Root at;  ///< of a point
  Index3 cell;
  bool is_inside;
};

/// The sign right behind a point.
int sign_behind(tests::Coefficients p, const Rational& t) {
  for (; !p.empty(); p = tests::derivative_of(p))
    if (const int sign = tests::sign_of(tests::value_of(p, t)); sign != 0) return sign;
  return 0;
}

/// Returns the points where the field's sign may change along a chord and the pieces between them,
/// from its first point to its last.
std::vector<Station> stations_on(const ExactChord& chord) {
  const auto sign_at = [&](const Rational& t) { return tests::sign_of(tests::value_of(chord.difference, t)); };
  const tests::SturmChart chart(chord.difference, chord.in, chord.out);
  std::vector<tests::SturmChart::Root> points{{chord.in, chord.in}};
  for (const auto& root : chart.roots())
    if (root.hi > chord.in) points.push_back(root);
  if (points.back().lo < chord.out) points.push_back({chord.out, chord.out});
  std::vector<Station> stations;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const bool is_exact = points[p].lo == points[p].hi;
    stations.push_back({true, points[p], chord.cell, !is_exact || sign_at(points[p].hi) >= 0});
    if (p + 1 == points.size()) break;
    // An interval contains its root, and no other up to its end.
    const int sign = is_exact ? sign_behind(chord.difference, points[p].hi) : sign_at(points[p].hi);
    stations.push_back({false, {}, chord.cell, sign >= 0});
  }
  return stations;
}

struct TrueCrossing {
  tests::SturmChart::Root at;
  Index3 cell;
  bool to_inside;
};

/// Returns all changes from one station to the next. A change to the inside counts at its point, in
/// the cell before; a change to the outside at the point behind which the ray is outside, in the
/// cell behind.
std::vector<TrueCrossing> crossings_by_brute_force(const TestGrid& grid, const Ray& ray, double isovalue) {
  std::vector<TrueCrossing> crossings;
  std::vector<Station> run;
  const auto end_run = [&] {
    for (std::size_t s = 1; s < run.size(); ++s) {
      const Station &before = run[s - 1], &here = run[s];
      if (before.is_inside == here.is_inside) continue;
      EXPECT_NE(before.is_point, here.is_point) << "neighbours disagree at their face";
      EXPECT_EQ(here.is_point, here.is_inside) << "the field is not continuous";
      crossings.push_back({here.is_point ? here.at : before.at, here.cell, here.is_inside});
    }
    run.clear();
  };
  for (const ExactChord& chord : tests::chords_of(grid, ray, isovalue)) {
    if (!chord.has_data) {
      end_run();
      continue;
    }
    const std::vector<Station> stations = stations_on(chord);
    run.insert(run.end(), stations.begin(), stations.end());
  }
  end_run();
  return crossings;
}

struct Stress {
  TestGrid grid;
  std::vector<Ray> rays;
  double isovalue;
};

/// Three of four grids have whole numbers, and rays from lattice point to lattice point: along
/// diagonals, edges and planes, so that many roots are in faces.
Stress any_stress(Dice& dice, std::uint64_t round) {
  const bool whole_values = dice.below(4) > 0;
  Stress made{.grid = tests::any_grid(dice, whole_values),
              .rays = {},
              .isovalue = whole_values ? static_cast<double>(dice.below(4) - 1) : dice.between(-0.3, 0.3)};
  made.rays = tests::stressful_rays(tests::far_corner(made.grid), 2, 500 + round);
  const Index3 n = made.grid.cell_count();
  for (int r = 0; r < 6; ++r) {
    Vec3 at, direction(0, 0, 0);
    for (int axis = 0; axis < 3; ++axis) {
      at[axis] = made.grid.plane(axis, dice.below(n[axis] + 1));
      while (direction == Vec3(0, 0, 0) || dice.coin()) direction[axis] = static_cast<double>(dice.below(5) - 2);
    }
    if (!whole_values) direction = dice.direction();
    made.rays.push_back({at - 8.0 * direction, direction});
  }
  return made;
}

bool are_equal(const GridCrossing& a, const GridCrossing& b) {
  return a.t.lo == b.t.lo && a.t.hi == b.t.hi && a.cell == b.cell && a.to_inside == b.to_inside;
}

TEST(ExactGridCrossings, agree_with_brute_force_on_stressful_rays) {
  Dice dice(31);
  int found = 0, touches = 0, many = 0, at_faces = 0;
  for (int round = 0; round < 100; ++round) {
    const auto [grid, rays, isovalue] = any_stress(dice, static_cast<std::uint64_t>(round));
    for (const Ray& ray : rays) {
      const auto crossings = exact_crossings(grid, ray, isovalue, width, all);
      const auto expected = crossings_by_brute_force(grid, ray, isovalue);
      ASSERT_EQ(crossings.size(), expected.size()) << round;
      many += crossings.size() > 2;
      for (std::size_t c = 0; c < crossings.size(); ++c) {
        const GridCrossing& crossing = crossings[c];
        ++found;
        ASSERT_EQ(crossing.to_inside, expected[c].to_inside) << round << " " << c;
        ASSERT_EQ(crossing.cell, expected[c].cell) << round << " " << c;
        ASSERT_TRUE(tests::holds(crossing.t.lo, crossing.t.hi, expected[c].at)) << round << " " << c;
        ASSERT_TRUE(crossing.t.width() <= width ||
                    std::nextafter(crossing.t.lo, std::numeric_limits<double>::infinity()) >= crossing.t.hi);
        if (c == 0) continue;
        ASSERT_TRUE(crossing.t.lo >= crossings[c - 1].t.lo && crossing.t.hi >= crossings[c - 1].t.hi) << round;
        at_faces += crossing.cell != crossings[c - 1].cell && crossing.t.lo == crossings[c - 1].t.lo;
        if (expected[c].to_inside || expected[c].at.lo != expected[c - 1].at.lo) continue;
        ++touches;
        ASSERT_TRUE(crossing.t.lo == crossings[c - 1].t.lo && crossing.t.hi == crossings[c - 1].t.hi) << round;
      }
    }
  }
  EXPECT_GT(found, 300);
  EXPECT_GT(many, 20);
  EXPECT_GT(touches, 10);
  EXPECT_GT(at_faces, 5);
}

TEST(ExactGridCrossings, begin_with_the_first_crossing) {
  Dice dice(32);
  int hits = 0, touches = 0;
  for (int round = 0; round < 400; ++round) {
    const auto [grid, rays, isovalue] = any_stress(dice, static_cast<std::uint64_t>(round));
    for (const Ray& ray : rays) {
      const GridRayVerdict first = exact_first_crossing(grid, ray, isovalue, width);
      const auto crossings = exact_crossings(grid, ray, isovalue, width, all);
      ASSERT_EQ(first.is_hit, !crossings.empty()) << round;
      if (!first.is_hit) continue;
      ++hits;
      touches += first.touches;
      ASSERT_TRUE(crossings[0].t.lo == first.t.lo && crossings[0].t.hi == first.t.hi) << round;
      ASSERT_EQ(crossings[0].cell, first.cell) << round;
      if (first.touches) {
        ASSERT_TRUE(crossings[0].to_inside) << round;
        ASSERT_TRUE(crossings.size() == 1 || crossings[1].to_inside || crossings[1].t.lo == first.t.lo) << round;
      }
      // One more than requested is never returned, and what is returned does not depend on it.
      for (std::size_t most = 0; most <= crossings.size(); ++most) {
        const auto some = exact_crossings(grid, ray, isovalue, width, most);
        ASSERT_EQ(some.size(), most) << round;
        for (std::size_t c = 0; c < most; ++c) ASSERT_TRUE(are_equal(some[c], crossings[c])) << round;
      }
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(touches, 20);
}

TEST(ExactGridCrossings, are_those_of_first_crossings_restarted_behind_each) {
  Dice dice(33);
  int compared = 0, skipped = 0;
  for (int round = 0; round < 60; ++round) {
    TestGrid grid({24, 19, 23}, [&](double, double, double) { return dice.between(-1, 1); });
    grid.levels = static_cast<int>(dice.below(4));
    const double isovalue = dice.between(-0.9, 0.9);
    const Vec3 direction = dice.direction();
    const Ray ray{dice.point({8, 8, 8}, {16, 11, 15}) - 30.0 * direction, direction};
    const auto crossings = exact_crossings(grid, ray, isovalue, width, all);
    Ray behind = ray;
    for (std::size_t c = 0; c <= crossings.size(); ++c) {
      const GridRayVerdict next = exact_first_crossing(grid, behind, isovalue, width);
      ASSERT_EQ(next.is_hit, c < crossings.size()) << round;
      if (!next.is_hit) break;
      if (c + 1 < crossings.size() && crossings[c + 1].t.lo - crossings[c].t.hi < 1e-6) {
        ++skipped;
        break;
      }
      ASSERT_TRUE(next.t.lo <= crossings[c].t.hi && next.t.hi >= crossings[c].t.lo) << round;
      ASSERT_EQ(next.cell, crossings[c].cell) << round;
      // Without gaps in the data, the sides alternate.
      ASSERT_EQ(crossings[c].to_inside, crossings[0].to_inside == (c % 2 == 0)) << round;
      ++compared;
      behind.t_min = next.t.hi + 1e-9;
    }
  }
  EXPECT_GT(compared, 250);
  EXPECT_LT(skipped, 3);
}

TEST(ExactGridCrossings, do_not_depend_on_regions) {
  Dice dice(34);
  std::size_t found = 0;
  for (int round = 0; round < 200; ++round) {
    TestGrid grid({16, 9, 13}, [&](double x, double y, double z) {
      return std::round(4 * std::sin(0.9 * x + 0.2 * y) + 0.1 * z + dice.between(-0.5, 0.5));
    });
    for (std::int64_t holes = dice.below(3); holes > 0; --holes)
      grid.at({dice.below(17), dice.below(10), dice.below(14)}) = nan;
    const Ray ray = tests::stressful_rays({16, 9, 13}, 1, 1300 + static_cast<std::uint64_t>(round))[0];
    const auto slow = exact_crossings(grid, ray, 2, width, all);
    grid.levels = 3;
    const auto quick = exact_crossings(grid, ray, 2, width, all);
    ASSERT_EQ(slow.size(), quick.size()) << round;
    for (std::size_t c = 0; c < slow.size(); ++c) {
      ASSERT_TRUE(slow[c].t.lo <= quick[c].t.hi && slow[c].t.hi >= quick[c].t.lo) << round;
      ASSERT_EQ(slow[c].cell, quick[c].cell) << round;
      ASSERT_EQ(slow[c].to_inside, quick[c].to_inside) << round;
    }
    found += slow.size();
  }
  EXPECT_GT(found, 150U);
}

struct Expected {
  double t;
  bool to_inside;
  Index3 cell;
};

void expect_crossings(const TestGrid& grid, const Ray& ray, double isovalue, const std::vector<Expected>& expected) {
  const auto crossings = exact_crossings(grid, ray, isovalue, width, all);
  ASSERT_EQ(crossings.size(), expected.size());
  for (std::size_t c = 0; c < expected.size(); ++c) {
    if (c > 0 && expected[c].t == expected[c - 1].t) {
      EXPECT_EQ(crossings[c].t.lo, crossings[c - 1].t.lo) << c;
      EXPECT_EQ(crossings[c].t.hi, crossings[c - 1].t.hi) << c;
    }
    EXPECT_TRUE(crossings[c].t.contains(expected[c].t) && crossings[c].t.width() <= width) << c;
    EXPECT_EQ(crossings[c].to_inside, expected[c].to_inside) << c;
    EXPECT_EQ(crossings[c].cell, expected[c].cell) << c;
  }
}

/// A row of cells along x whose values depend on x alone, and the ray along it.
TestGrid row(const std::vector<double>& values) {
  return {{static_cast<std::int64_t>(values.size()) - 1, 1, 1},
          [&](double x, double, double) { return values[static_cast<std::size_t>(x)]; }};
}
const Ray along{{-1, 0.5, 0.25}, {1, 0, 0}};

TEST(ExactGridCrossings, count_a_face_at_the_isovalue_once) {
  expect_crossings(row({-1, 0, 1, 0, -1}), along, 0, {{2, true, {0, 0, 0}}, {4, false, {3, 0, 0}}});
}

TEST(ExactGridCrossings, enter_and_leave_at_one_t_where_a_ray_touches_from_outside) {
  expect_crossings(row({-1, 0, -1, 3}), along, 0,
                   {{2, true, {0, 0, 0}}, {2, false, {1, 0, 0}}, {3.25, true, {2, 0, 0}}});
}

TEST(ExactGridCrossings, say_nothing_where_a_ray_touches_from_inside) {
  expect_crossings(row({1, 0, 1, 0, 0, 1}), along, 0, {});
}

TEST(ExactGridCrossings, take_cells_at_the_isovalue_as_inside) {
  expect_crossings(row({-1, 0, 0, 0, -1}), along, 0, {{2, true, {0, 0, 0}}, {4, false, {3, 0, 0}}});
  expect_crossings(row({0, 0, 0}), along, 0, {});
}

TEST(ExactGridCrossings, touch_in_the_middle_of_a_cell) {
  // u (1 - u) along the diagonal of a cell
  const TestGrid saddle({1, 1, 1}, [](double x, double y, double) { return x * y; });
  expect_crossings(saddle, {{-1, 2, 0.5}, {1, -1, 0}}, 0.25, {{1.5, true, {0, 0, 0}}, {1.5, false, {0, 0, 0}}});
}

TEST(ExactGridCrossings, count_lattice_points_edges_and_planes_once) {
  const TestGrid sum({4, 4, 4}, [](double x, double y, double z) { return x + y + z; });
  expect_crossings(sum, {{-1, -1, -1}, {1, 1, 1}}, 6, {{3, true, {1, 1, 1}}});
  expect_crossings(sum, {{5, 5, 5}, {-1, -1, -1}}, 6, {{3, false, {1, 1, 1}}});
  expect_crossings(sum, {{-1, 2, 2}, {1, 0, 0}}, 6, {{3, true, {1, 2, 2}}});   // along an edge
  expect_crossings(sum, {{-1, -1, 4}, {1, 1, 0}}, 6, {{2, true, {0, 0, 3}}});  // in the last plane
  // A lattice point that is touched, along a diagonal through cells that share nothing else.
  const TestGrid peak(
      {4, 4, 4}, [](double x, double y, double z) { return -std::abs(x - 2) - std::abs(y - 2) - std::abs(z - 2); });
  expect_crossings(peak, {{-1, -1, -1}, {1, 1, 1}}, 0, {{3, true, {1, 1, 1}}, {3, false, {2, 2, 2}}});
}

TEST(ExactGridCrossings, forget_their_side_where_data_are_missing) {
  expect_crossings(row({-1, 1, nan, 1, -1, nan, -1, 1}), along, 0,
                   {{1.5, true, {0, 0, 0}}, {4.5, false, {3, 0, 0}}, {7.5, true, {6, 0, 0}}});
  expect_crossings(row({-1, 1, nan, -1, 1}), along, 0, {{1.5, true, {0, 0, 0}}, {4.5, true, {3, 0, 0}}});
  expect_crossings(row({-1, -1, nan, 1, 1}), along, 0, {});
  // The same in regions of two cells. The search skips the second and the third region.
  TestGrid skipped = row({1, -1, -1, -1, nan, 1, 1, 1, -1});
  skipped.levels = 1;
  expect_crossings(skipped, along, 0, {{1.5, false, {0, 0, 0}}, {8.5, false, {7, 0, 0}}});
}

TEST(ExactGridCrossings, count_the_last_point_of_data_or_ray_once) {
  expect_crossings(row({-1, 0}), along, 0, {{2, true, {0, 0, 0}}});
  expect_crossings(row({-1, 0, nan, 0, -1}), along, 0, {{2, true, {0, 0, 0}}, {4, false, {3, 0, 0}}});
  expect_crossings(row({-1, 0, -1}), {along.origin, along.direction, 0, 2}, 0, {{2, true, {0, 0, 0}}});
  expect_crossings(row({-1, 0, -1}), {along.origin, along.direction, 2}, 0, {{2, false, {1, 0, 0}}});
  expect_crossings(row({-1, 0, 1}), {along.origin, along.direction, 2}, 0, {});
}

TEST(ExactGridCrossings, have_enclosures_that_never_step_back) {
  // From far away the t of a face is not precise: crossings shortly before and behind it have
  // enclosures that overlap.
  Dice dice(35);
  int overlaps = 0;
  for (int round = 0; round < 3000; ++round) {
    const double peak = std::pow(10, dice.between(-9, -1));
    const TestGrid grid = row({-1, peak, -dice.between(0.1, 10), peak, -1});
    const double length = dice.between(0.1, 3);
    const Ray ray{{-std::pow(10, dice.between(4, 9)), 0.3, 0.4}, {length, 0, 0}};
    const double wide = std::pow(10, dice.between(-8, -2));
    const auto crossings = exact_crossings(grid, ray, 0, wide, all);
    ASSERT_EQ(crossings.size(), 4U) << round;
    for (std::size_t c = 1; c < 4; ++c) {
      ASSERT_TRUE(crossings[c].t.lo >= crossings[c - 1].t.lo && crossings[c].t.hi >= crossings[c - 1].t.hi) << round;
      overlaps += crossings[c].t.lo < crossings[c - 1].t.hi;
    }
  }
  EXPECT_GT(overlaps, 100);
}

TEST(ExactGridCrossings, are_none_for_what_is_no_ray) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const Ray& ray :
       {Ray{{0, 0, 0}, {0, 0, 0}}, Ray{{nan, 0.5, 0.5}, {1, 0, 0}}, Ray{{0, 0.5, 0.5}, {infinity, 0, 0}},
        Ray{{0, 0.5, 0.5}, {1e-320, 0, 0}}, Ray{{0, 0.5, 0.5}, {1, 0, 0}, nan}, Ray{{0, 0.5, 0.5}, {1, 0, 0}, 2, 1}})
    EXPECT_TRUE(exact_crossings(row({-1, 1}), ray, 0, width, all).empty());
}

}  // namespace
}  // namespace rhoray::render
