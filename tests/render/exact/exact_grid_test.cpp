#include "render/exact/exact_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/render/exact/chords.h"

namespace rhoray::render {
namespace {

using tests::any_grid;
using tests::chords_of;
using tests::Dice;
using tests::exact;
using tests::ExactChord;
using tests::far_corner;
using tests::Rational;
using tests::TestGrid;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double width = 1e-13;

struct BruteHit {
  Index3 cell;
  tests::SturmChart::Root at;
  bool touches;
};

std::optional<BruteHit> first_crossing_by_brute_force(const TestGrid& grid, const Ray& ray, double isovalue) {
  const std::vector<ExactChord> chords = chords_of(grid, ray, isovalue);
  bool is_known = false, side = false;
  for (std::size_t c = 0; c < chords.size(); ++c) {
    const ExactChord& chord = chords[c];
    if (!chord.has_data) {
      is_known = false;
      continue;
    }
    if (!is_known) side = tests::value_of(chord.difference, chord.in) >= 0;
    is_known = true;
    const auto corner = grid.corners(chord.cell);
    if (std::all_of(corner.begin(), corner.end(), [&](double f) { return (f >= isovalue) == side; })) continue;
    const auto change = tests::SturmChart(chord.difference, chord.in, chord.out).first_change(side);
    if (!change) continue;
    BruteHit hit{chord.cell, change->at, change->touches};
    if (hit.touches && change->at.lo == chord.out && c + 1 < chords.size() && chords[c + 1].has_data) {
      const auto leaves =
          tests::SturmChart(chords[c + 1].difference, chords[c + 1].in, chords[c + 1].out).first_change(true);
      hit.touches = leaves && leaves->at.lo == chord.out;
    }
    return hit;
  }
  return std::nullopt;
}

TEST(ExactGrid, agrees_with_brute_force_on_stressful_rays) {
  Dice dice(11);
  int hits = 0, touches = 0, exact_cells = 0, filtered = 0;
  for (int round = 0; round < 60; ++round) {
    const bool whole_values = dice.coin();
    const TestGrid grid = any_grid(dice, whole_values);
    const double isovalue = whole_values ? static_cast<double>(dice.below(3) - 1) : dice.between(-0.5, 0.5);
    for (const Ray& ray : tests::stressful_rays(far_corner(grid), 4, 100 + static_cast<std::uint64_t>(round))) {
      const GridRayVerdict verdict = exact_first_crossing(grid, ray, isovalue, width);
      const auto hit = first_crossing_by_brute_force(grid, ray, isovalue);
      ASSERT_EQ(verdict.is_hit, hit.has_value()) << round;
      exact_cells += verdict.effort.exact > 0;
      filtered += verdict.effort.filtered > 0;
      if (!hit) continue;
      ++hits;
      touches += hit->touches;
      ASSERT_EQ(verdict.cell, hit->cell) << round;
      ASSERT_EQ(verdict.touches, hit->touches) << round;
      ASSERT_TRUE(tests::holds(verdict.t.lo, verdict.t.hi, hit->at)) << round;
      ASSERT_TRUE(verdict.t.width() <= width || std::nextafter(verdict.t.lo, infinity) >= verdict.t.hi) << round;
    }
  }
  EXPECT_GT(hits, 30);
  EXPECT_GT(touches, 0);
  EXPECT_GT(exact_cells, 15);
  EXPECT_GT(filtered, 30);
}

TEST(ExactGrid, finds_the_largest_value_of_brute_force) {
  Dice dice(12);
  int found = 0;
  for (int round = 0; round < 25; ++round) {
    const TestGrid grid = any_grid(dice, dice.coin());
    for (const Ray& ray : tests::stressful_rays(far_corner(grid), 4, 200 + static_cast<std::uint64_t>(round))) {
      const GridMaximumVerdict verdict = exact_largest_value(grid, ray, width);
      const std::vector<ExactChord> chords = chords_of(grid, ray, 0);
      const bool has_data = std::any_of(chords.begin(), chords.end(), [](const ExactChord& c) { return c.has_data; });
      ASSERT_EQ(verdict.has_value, has_data) << round;
      if (!has_data) continue;
      ++found;
      ASSERT_TRUE(std::nextafter(verdict.value.lo, infinity) >= verdict.value.hi) << round;
      // By Sturm's theorem, the field is nowhere above the enclosure. Somewhere it is above or at
      // its lower end, for the first time in the given cell.
      bool reached = false;
      for (const ExactChord& chord : chords) {
        if (!chord.has_data) continue;
        const auto above = [&](double level, bool strictly) {
          tests::Coefficients difference = chord.difference;
          if (difference.empty()) difference.push_back(0);
          difference[0] -= exact(level);
          if (strictly)
            for (Rational& c : difference) c = -c;
          // Strictly: starting inside "value <= level", does it leave?
          return tests::SturmChart(difference, chord.in, chord.out).first_change(strictly).has_value();
        };
        ASSERT_FALSE(above(verdict.value.hi, true)) << round;
        if (!reached && above(verdict.value.lo, false)) {
          reached = true;
          // Where enclosures are not exact numbers, an earlier cell may almost reach the value.
          if (verdict.value.lo == verdict.value.hi) {
            ASSERT_EQ(verdict.cell, chord.cell) << round;
          }
        }
      }
      ASSERT_TRUE(reached) << round;
    }
  }
  EXPECT_GT(found, 40);
}

TEST(ExactGrid, skips_regions_without_changing_a_verdict) {
  Dice dice(13);
  int skipped = 0;
  for (int round = 0; round < 300; ++round) {
    TestGrid grid({16, 9, 13}, [&](double x, double y, double z) {
      return std::sin(0.4 * x) + 0.1 * y - 0.07 * z + dice.between(0, 0.02);
    });
    if (dice.coin()) grid.at({dice.below(16), dice.below(9), dice.below(13)}) = nan;
    const double isovalue = dice.between(-1, 1);
    const Ray ray = tests::stressful_rays({16, 9, 13}, 1, 300 + static_cast<std::uint64_t>(round))[0];
    const GridRayVerdict slow = exact_first_crossing(grid, ray, isovalue, width);
    const GridMaximumVerdict slow_maximum = exact_largest_value(grid, ray, width);
    grid.levels = 3;
    const GridRayVerdict quick = exact_first_crossing(grid, ray, isovalue, width);
    const GridMaximumVerdict quick_maximum = exact_largest_value(grid, ray, width);
    ASSERT_EQ(slow.is_hit, quick.is_hit) << round;
    ASSERT_EQ(slow.touches, quick.touches) << round;
    ASSERT_TRUE(slow.t.lo <= quick.t.hi && slow.t.hi >= quick.t.lo) << round;
    ASSERT_EQ(slow.cell, quick.cell) << round;
    ASSERT_EQ(slow_maximum.value.lo, quick_maximum.value.lo) << round;
    ASSERT_EQ(slow_maximum.cell, quick_maximum.cell) << round;
    skipped += quick.effort.regions_skipped > 0;
  }
  EXPECT_GT(skipped, 150);
}

TestGrid ramp() {
  return TestGrid({4, 4, 4}, [](double x, double, double) { return x; });
}

TEST(ExactGrid, crosses_at_a_face_once_and_says_in_which_cell) {
  const GridRayVerdict from_outside = exact_first_crossing(ramp(), {{-1, 1.5, 1.5}, {1, 0, 0}}, 2, width);
  ASSERT_TRUE(from_outside.is_hit);
  EXPECT_EQ(from_outside.t.lo, 3);
  EXPECT_EQ(from_outside.t.hi, 3);
  EXPECT_FALSE(from_outside.touches);
  EXPECT_EQ(from_outside.cell, Index3(1, 1, 1)) << "the cell before";
  const GridRayVerdict from_inside = exact_first_crossing(ramp(), {{5, 1.5, 1.5}, {-1, 0, 0}}, 2, width);
  EXPECT_EQ(from_inside.t.lo, 3);
  EXPECT_EQ(from_inside.cell, Index3(1, 1, 1)) << "the cell behind";
}

TEST(ExactGrid, touches_where_a_ridge_lies_in_a_face) {
  const TestGrid ridge({4, 4, 4}, [](double x, double, double) { return -std::abs(x - 2); });
  const GridRayVerdict verdict = exact_first_crossing(ridge, {{-1, 1.5, 1.5}, {1, 0, 0}}, 0, width);
  ASSERT_TRUE(verdict.is_hit);
  EXPECT_TRUE(verdict.touches);
  EXPECT_EQ(verdict.t.lo, 3);
  // At the border of the data the ray is inside at its last point only.
  const GridRayVerdict border = exact_first_crossing(ramp(), {{-1, 1.5, 1.5}, {1, 0, 0}}, 4, width);
  EXPECT_TRUE(border.is_hit && border.touches);
}

TEST(ExactGrid, V07_sees_a_ray_in_an_outer_face) {
  const GridRayVerdict verdict = exact_first_crossing(ramp(), {{-1, 4, 0}, {1, 0, -0.0}}, 1.5, width);
  ASSERT_TRUE(verdict.is_hit);
  EXPECT_TRUE(verdict.t.contains(2.5));
  EXPECT_EQ(verdict.cell, Index3(1, 3, 0));
  EXPECT_FALSE(exact_first_crossing(ramp(), {{-1, std::nextafter(4, 5), 0}, {1, 0, 0}}, 1.5, width).is_hit);
}

TEST(ExactGrid, V08_has_no_hit_where_a_ray_meets_a_corner_only) {
  EXPECT_FALSE(exact_first_crossing(ramp(), {{-1, 1, 2}, {1, -1, 0}}, 0, width).is_hit);
  EXPECT_FALSE(exact_largest_value(ramp(), {{-1, 1, 2}, {1, -1, 0}}, width).has_value);
}

TEST(ExactGrid, R15_goes_through_the_upper_cell_of_a_plane) {
  EXPECT_EQ(exact_first_crossing(ramp(), {{-1, 2, 2}, {1, 0, 0}}, 1.5, width).cell, Index3(1, 2, 2));
}

TEST(ExactGrid, R17_follows_a_diagonal_through_lattice_points) {
  const TestGrid sum({8, 8, 8}, [](double x, double y, double z) { return x + y + z; });
  const GridRayVerdict verdict = exact_first_crossing(sum, {{-1, -1, -1}, {1, 1, 1}}, 10, width);
  ASSERT_TRUE(verdict.is_hit);
  EXPECT_TRUE(verdict.t.contains(1 + 10.0 / 3));
  EXPECT_EQ(verdict.effort.cells_visited, 4);
}

TEST(ExactGrid, honours_t_min_and_t_max) {
  const Ray ray{{-1, 1.5, 1.5}, {1, 0, 0}};
  EXPECT_TRUE(exact_first_crossing(ramp(), {ray.origin, ray.direction, 0, 3}, 2, width).is_hit);
  EXPECT_FALSE(exact_first_crossing(ramp(), {ray.origin, ray.direction, 0, std::nextafter(3, 2)}, 2, width).is_hit);
  EXPECT_FALSE(exact_first_crossing(ramp(), {ray.origin, ray.direction, 3}, 2, width).is_hit) << "starts inside";
  EXPECT_EQ(exact_largest_value(ramp(), {ray.origin, ray.direction, 0, 2.25}, width).value.lo, 1.25);
}

TEST(ExactGrid, R31_starts_inside_on_the_surface_itself) {
  EXPECT_FALSE(exact_first_crossing(ramp(), {{2, 1.5, 1.5}, {1, 0, 0}}, 2, width).is_hit);
  const GridRayVerdict down = exact_first_crossing(ramp(), {{2, 1.5, 1.5}, {-1, 0, 0}}, 2, width);
  ASSERT_TRUE(down.is_hit) << "leaves at once";
  EXPECT_EQ(down.t.hi, 0);
}

TEST(ExactGrid, D07_sees_no_surface_against_missing_data) {
  TestGrid grid({5, 1, 1}, [](double x, double, double) { return x < 3 ? -1 : 1; });
  grid.at({2, 0, 0}) = grid.at({3, 0, 0}) = nan;
  EXPECT_FALSE(exact_first_crossing(grid, {{-1, 0.5, 0.5}, {1, 0, 0}}, 0, width).is_hit);
  EXPECT_EQ(exact_largest_value(grid, {{-1, 0.5, 0.5}, {1, 0, 0}}, width).t.lo, 5);
}

TEST(ExactGrid, refuses_what_is_no_ray) {
  for (const Ray& ray :
       {Ray{{0, 0, 0}, {0, 0, 0}}, Ray{{nan, 1, 1}, {1, 0, 0}}, Ray{{0, 1, 1}, {infinity, 0, 0}},
        Ray{{0, 1, 1}, {1e-320, 0, 0}}, Ray{{0, 1, 1}, {1, 0, 0}, nan}, Ray{{0, 1, 1}, {1, 0, 0}, 2, 1}})
    EXPECT_FALSE(exact_first_crossing(ramp(), ray, 2, width).is_hit);
}

TEST(ExactGrid, V19_keeps_its_width_from_far_away) {
  const GridRayVerdict verdict = exact_first_crossing(ramp(), {{-1e7, 1.3, 1.4}, {1, 1e-9, 0}}, 1.0 / 3, 1e-12);
  ASSERT_TRUE(verdict.is_hit);
  EXPECT_TRUE(std::nextafter(verdict.t.lo, infinity) >= verdict.t.hi);
}

TEST(ExactGrid, M02_gives_the_first_t_of_a_plateau) {
  const TestGrid plateau({6, 2, 2}, [](double x, double, double) { return std::min(x, 2.0); });
  const GridMaximumVerdict verdict = exact_largest_value(plateau, {{-1, 0.5, 0.5}, {1, 0, 0}}, width);
  EXPECT_EQ(verdict.value.hi, 2);
  EXPECT_EQ(verdict.t.lo, 3);
  EXPECT_EQ(verdict.cell, Index3(1, 0, 0));
}

TEST(ExactGrid, M03_gives_the_first_of_equal_maxima_in_distant_cells) {
  // A field of period 2 along a diagonal: the same cubic repeats, and its maximum is usually
  // irrational.
  Dice dice(14);
  int irrational = 0;
  for (int round = 0; round < 100; ++round) {
    std::array<double, 8> values{};
    for (double& f : values) f = dice.between(-1, 1);
    const TestGrid periodic({8, 8, 8}, [&](double x, double y, double z) {
      const auto odd = [](double c) { return static_cast<std::size_t>(c) % 2; };
      return values[odd(x) + 2 * odd(y) + 4 * odd(z)];
    });
    const GridMaximumVerdict verdict = exact_largest_value(periodic, {{0.25, 0.5, 0.125}, {1, 1, 1}}, width);
    ASSERT_TRUE(verdict.has_value);
    // At a position that the first period, begun halfway, does not contain.
    if (verdict.t.lo > 2) continue;
    ASSERT_LT(verdict.t.hi, 2.125);
    irrational += verdict.value.lo < verdict.value.hi && verdict.effort.exact > 2;
  }
  EXPECT_GT(irrational, 20);
}

}  // namespace
}  // namespace rhoray::render
