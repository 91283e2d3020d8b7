#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/grid/reference/largest.h"
#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Method;
using render::Ray;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Noise of `kinds` different values from `low` upwards.
Samples noise(std::int64_t kinds, double low) {
  return [=](const Index3& at) {
    const auto hash = static_cast<std::uint64_t>((at.z * 1009 + at.y) * 1013 + at.x + 7) * 0x9e3779b97f4a7c15U;
    return low + static_cast<double>((hash >> 35) % static_cast<std::uint64_t>(kinds));
  };
}

TEST(GridLargestValue, is_what_looking_into_every_cell_finds) {
  const Index3 cells(8, 7, 9);
  const Samples with_holes = [](const Index3& at) { return at.x == 4 && at.y < 5 ? nan : noise(200, -100)(at); };
  const Samples negative = noise(100, -200);
  int inside_a_cell = 0, rays = 0;
  for (const Samples& samples : {noise(1000, 0), negative, with_holes}) {
    TracedDataset traced(volume_of<double>({9, 8, 10}, samples), {.macro_factor = 2});
    for (const Ray& ray : stressful_rays({8, 7, 9}, 900, 1)) {
      if (ray.origin.length() > 1e4 || std::abs(ray.direction.length() - 1) > 0.9) continue;
      // In a plane the traversal takes one of two cells, and only one of them may have data.
      bool in_a_plane = false;
      for (int axis = 0; axis < 3; ++axis) in_a_plane = in_a_plane || std::abs(ray.direction[axis]) < 1e-4;
      if (in_a_plane) continue;
      const auto exact = largest_by_brute_force(samples, cells, ray);
      const auto face = largest_by_brute_force(samples, cells, ray, true);
      const Hit hit = traced.largest_value(ray), face_hit = traced.largest_value(ray, face_rule);
      if (!exact) continue;  // only touches cells
      ASSERT_FALSE(hit.is_miss());
      EXPECT_NEAR(hit.value, *exact, 1e-8);
      EXPECT_NEAR(face_hit.value, *face, 1e-8);
      EXPECT_LE(face_hit.value, hit.value + 1e-12);
      inside_a_cell += *exact > *face + 1e-6;
      ++rays;
      const auto at_hit = interpolated(samples, cell_of(ray.at(hit.t), cells), ray.at(hit.t));
      if (!std::isnan(static_cast<double>(at_hit))) {
        EXPECT_NEAR(static_cast<double>(at_hit), hit.value, 1e-7);
      }
    }
  }
  EXPECT_GT(rays, 300);
  EXPECT_GT(inside_a_cell, 20) << "the face rule misses nothing here: is this still the hard field? (M01)";
}

// u (1 - v) + (1 - u) v along the cell's diagonal: 0 at both ends, 1/2 in the middle.
TEST(GridLargestValue, by_the_face_rule_misses_a_maximum_inside_a_cell_and_the_exact_method_does_not) {
  TracedDataset traced(volume_of<float>({2, 2, 2}, [](const Index3& at) { return at.x != at.y ? 1.0F : 0.0F; }));
  const Ray ray{.origin = {-1, -1, 0.25}, .direction = {1, 1, 0}};
  EXPECT_EQ(traced.largest_value(ray, face_rule).value, 0);
  const Hit hit = traced.largest_value(ray, Method{});
  EXPECT_EQ(hit.value, 0.5);
  EXPECT_NEAR(hit.t, 1.5, 1e-15);
}

TEST(GridLargestValue, is_the_same_with_and_without_hierarchy_and_last_t_bit_for_bit) {
  const std::vector<Samples> kinds{
      noise(100000, -50000),
      noise(3, 0),
      [](const Index3&) { return 0.1; },
      [](const Index3& at) { return std::min(0.7, 0.01 * static_cast<double>(at.x * at.y)); },
      [](const Index3& at) { return noise(9, 0)(at) == 0 ? nan : noise(50, -3)(at); },
      [](const Index3& at) { return noise(11, 0)(at) == 3 ? -1e9 : noise(50, -3)(at); }};
  int hits = 0;
  for (const Samples& samples : kinds) {
    TracedDataset traced(volume_of<double>({18, 20, 17}, samples), {.macro_factor = 3, .macro_level_count = 2});
    for (const Method& method : {Method{}, face_rule})
      for (const Ray& ray : stressful_rays({17, 19, 16}, 500, 2)) {
        const Hit reference = traced.largest_value(ray, method, false, false);
        ASSERT_TRUE(same_bits(traced.largest_value(ray, method, true, false), reference)) << "hierarchy";
        // The previous ray's t may be anything: another ray's, in front of the volume, behind it.
        for (const double t : {traced.scratch.last_t.value_or(0), -5.0, 9.0, 1e9}) {
          traced.scratch.last_t = t;
          ASSERT_TRUE(same_bits(traced.largest_value(ray, method, true, true), reference)) << "last t " << t;
        }
        hits += !reference.is_miss();
      }
  }
  EXPECT_GT(hits, 3000);
}

TEST(GridLargestValue, with_last_t_opens_fewer_cells) {
  TracedDataset traced(
      sampled_volume<double>({40, 40, 40}, {}, [](const Vec3& p) { return -(p - Vec3(20, 20, 20)).length(); }));
  const auto work = [&](bool use_last_t) {
    traced.scratch = {};
    for (int i = 0; i < 100; ++i)
      traced.largest_value({.origin = {-2, 10 + 0.1 * i, 18.3}, .direction = {1, 0, 0}}, Method{}, true, use_last_t);
    return traced.scratch.counters.cells_visited + traced.scratch.counters.macrocells_visited;
  };
  const auto without = work(false);
  EXPECT_LE(work(true), without);
}

// M02, M05. Interpolation between equal numbers rounds: a plateau became noise in the last digits,
// and its first point was lost in it.
TEST(GridLargestValue, of_a_constant_volume_is_that_value_where_the_ray_comes_in) {
  for (const double value : {0.1, -0.3, 7.0, 1e30}) {
    TracedDataset traced(volume_of<double>({33, 33, 33}, [=](const Index3&) { return value; }));
    Dice dice(3);
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 direction = dice.direction();
      const Ray ray{.origin = dice.point({1, 1, 1}, {31, 31, 31}) - 100.0 * direction, .direction = direction};
      const auto part = part_in_box(ray, {0, 0, 0}, {32, 32, 32});
      traced.scratch.counters = {};
      const Hit hit = traced.largest_value(ray);
      EXPECT_EQ(hit.value, value);
      EXPECT_NEAR(hit.t, (*part)[0], 1e-12);
      EXPECT_LE(traced.scratch.counters.cells_solved, 3U) << "a plateau is settled where the ray meets it";
    }
  }
}

TEST(GridLargestValue, takes_the_smallest_t_among_equals) {
  // Two ridges of the same height, and a plateau of three layers.
  TracedDataset ridges(
      volume_of<double>({24, 4, 4}, [](const Index3& at) { return at.x == 5 || at.x == 17 ? 0.3 : 0.1; }));
  TracedDataset plateau(
      volume_of<double>({24, 4, 4}, [](const Index3& at) { return at.x >= 9 && at.x <= 11 ? 0.3 : 0.1; }));
  Dice dice(4);
  for (int trial = 0; trial < 100; ++trial) {
    const Ray ray{.origin = {-1, dice.between(0, 3), dice.between(0, 3)}, .direction = {1, 0, 0}};
    EXPECT_EQ(ridges.largest_value(ray).value, 0.3);
    EXPECT_EQ(ridges.largest_value(ray).t, 6);
    EXPECT_EQ(plateau.largest_value(ray).value, 0.3);
    EXPECT_EQ(plateau.largest_value(ray).t, 10);
    EXPECT_EQ(ridges.largest_value(ray, face_rule).t, 6);
  }
}

/// Two cells at a face across `axis`, the first below the second: random, highest on the face.
std::array<render::TrilinearCell, 2> cells_at_ridge(Dice& dice, int axis, double offset, double size) {
  std::array<render::TrilinearCell, 2> cells;
  for (std::size_t c = 0; c < 8; ++c) {
    const bool is_high = (c >> axis & 1) != 0;
    const std::size_t beyond = c ^ std::size_t{1} << axis;
    cells[0].corner[c] = offset + size * (is_high ? dice.between(1, 2) : dice.between(-3, 1));
    if (is_high) cells[1].corner[beyond] = cells[0].corner[c];
  }
  for (std::size_t c = 0; c < 8; ++c)
    if ((c >> axis & 1) != 0) cells[1].corner[c] = offset + size * dice.between(-3, 1);
  return cells;
}

// M08. Where a ray's largest value is on the plane between two cells, rounding must not decide
// which of them has it.
TEST(GridLargestValue, on_a_face_has_the_same_bits_in_both_cells) {
  struct Numbers {
    double offset, size;
  };
  Dice dice(11);
  int on_face = 0;
  for (const Numbers& numbers : {Numbers{0, 1}, Numbers{1e9, 1e-3}, Numbers{-0.1, 1e30}, Numbers{0, 1e-310}})
    for (int trial = 0; trial < 4000; ++trial) {
      const int axis = trial % 3;
      const auto cells = cells_at_ridge(dice, axis, numbers.offset, numbers.size);
      const bool rises = dice.below(2) == 0;
      Vec3 in = dice.point({0, 0, 0}, {1, 1, 1}), at = dice.point({0, 0, 0}, {1, 1, 1}),
           out = dice.point({0, 0, 0}, {1, 1, 1});
      // On an edge.
      if (dice.below(4) == 0) at[(axis + 1) % 3] = static_cast<double>(dice.below(2));
      Vec3 at_beyond = at;
      at[axis] = rises ? 1 : 0, at_beyond[axis] = rises ? 0 : 1;
      const render::CellVisit before{.cell = {}, .t_in = 0, .t_out = 1, .axis_in = -1, .axis_out = axis};
      const render::CellVisit behind{.cell = {}, .t_in = 1, .t_out = 2, .axis_in = axis, .axis_out = -1};
      const render::TrilinearCell &first = cells[rises ? 0 : 1], &second = cells[rises ? 1 : 0];
      const auto leaving = render::largest_in_cell<double>(first, before, in, at, first.largest(), false);
      const auto entering = render::largest_in_cell<double>(second, behind, at_beyond, out, second.largest(), false);
      const auto in_single = render::largest_in_cell<float>(first, before, in, at, first.largest(), true);
      if (leaving.s != 1 || entering.s != 0) continue;  // higher inside
      ++on_face;
      EXPECT_EQ(leaving.value, entering.value);
      EXPECT_EQ(in_single.value, leaving.value);
      EXPECT_LE(leaving.value, std::min(first.largest(), second.largest()));
      // Both sums round a few times, the smallest numbers to whole steps.
      constexpr double step = std::numeric_limits<double>::denorm_min();
      EXPECT_NEAR(leaving.value, first.at(at), 1e-15 * (std::abs(numbers.offset) + 8 * numbers.size) + 8 * step);
    }
  EXPECT_GT(on_face, 5000);
}

TEST(GridLargestValue, is_never_below_what_it_is_on_the_faces_that_the_ray_passes) {
  Dice dice(12);
  for (int trial = 0; trial < 20000; ++trial) {
    render::TrilinearCell cell;
    // Down to the rounding of 1.
    const double size = std::ldexp(1.0, -static_cast<int>(dice.below(60)));
    for (double& value : cell.corner) value = 1 + size * dice.between(-1, 1);
    const int axis_in = trial % 3, axis_out = trial / 3 % 3;
    Vec3 in = dice.point({0, 0, 0}, {1, 1, 1}), out = in + size * dice.point({-1, -1, -1}, {1, 1, 1});
    for (int a = 0; a < 3; ++a) out[a] = std::clamp(out[a], 0.0, 1.0);
    in[axis_in] = 0, out[axis_out] = 1;
    const render::CellVisit visit{.cell = {}, .t_in = 0, .t_out = 1, .axis_in = axis_in, .axis_out = axis_out};
    const auto largest = render::largest_in_cell<double>(cell, visit, in, out, cell.largest(), false);
    EXPECT_GE(largest.value, render::value_on_face(cell, in, axis_in));
    EXPECT_GE(largest.value, render::value_on_face(cell, out, axis_out));
    EXPECT_LE(largest.value, cell.largest());
  }
}

// M03. Both cells at a ridge reach the same value at the same t, whichever is opened first.
TEST(GridLargestValue, on_a_face_belongs_to_the_cell_that_the_ray_enters_first) {
  Dice dice(13);
  for (const int ridge : {3, 7, 8, 15, 16}) {  // within macrocells and between them
    const Samples samples = [&](const Index3& at) {
      const double noise = static_cast<double>((at.x * 7 + at.y * 13 + at.z * 29) % 11);
      // In addition, the cells on one side of the ridge or the other are the higher ones, and are
      // opened first.
      return at.x == ridge ? 50 + noise : at.x == ridge - 1 + 2 * (at.z % 2) ? 30 + 3 * noise : noise;
    };
    TracedDataset traced(volume_of<float>({24, 24, 24}, samples), {.macro_factor = 4});
    int on_the_ridge = 0;
    for (int trial = 0; trial < 400; ++trial) {
      const bool rises = trial % 2 == 0;
      const Vec3 at(ridge, dice.between(1, 22), dice.between(1, 22));
      const Vec3 direction(rises ? 1 : -1, dice.between(-0.9, 0.9), dice.between(-0.9, 0.9));
      for (const Method& method : {Method{}, face_rule, Method{.precision = Method::Precision::float32}}) {
        const Hit hit = traced.largest_value({.origin = at - 0.9 * direction, .direction = direction}, method);
        const Vec3 p = at - 0.9 * direction + hit.t * direction;
        if (std::abs(p.x - ridge) > 1e-9) continue;  // higher inside a cell
        EXPECT_EQ(static_cast<int>(hit.cell % 23), rises ? ridge - 1 : ridge) << "from " << p << " along " << direction;
        ++on_the_ridge;
      }
    }
    EXPECT_GT(on_the_ridge, 400) << "of 1200";
  }
}

// M04.
TEST(GridLargestValue, of_negative_values_is_negative) {
  TracedDataset traced(
      volume_of<std::int16_t>({8, 8, 8}, [](const Index3& at) { return static_cast<std::int16_t>(-1000 + at.x); }));
  EXPECT_EQ(traced.largest_value({.origin = {-1, 3.5, 3.5}, .direction = {1, 0, 0}}).value, -993);
}

// M07.
TEST(GridLargestValue, is_found_in_the_outer_faces_edges_and_corners) {
  for (const Index3& place : {Index3(0, 0, 0), Index3(6, 6, 6), Index3(6, 0, 3), Index3(3, 6, 3)}) {
    TracedDataset traced(volume_of<std::uint8_t>({7, 7, 7}, [=](const Index3& at) { return at == place ? 255 : 9; }));
    const Vec3 target(static_cast<double>(place.x), static_cast<double>(place.y), static_cast<double>(place.z));
    const Vec3 direction = (Vec3(3, 3, 3) - target + Vec3(0.1, 0.2, 0.3)).normalized();
    EXPECT_NEAR(traced.largest_value({.origin = target - 4.0 * direction, .direction = direction}).value, 255, 1e-10);
    EXPECT_NEAR(traced.largest_value({.origin = target + 9.0 * direction, .direction = -direction}).value, 255, 1e-10);
  }
}

TEST(GridLargestValue, is_a_miss_where_there_is_no_data) {
  TracedDataset traced(
      volume_of<float>({9, 9, 9}, [](const Index3& at) { return at.x > 4 ? 1.0F : static_cast<float>(nan); }));
  EXPECT_TRUE(traced.largest_value({.origin = {2, 4.5, -1}, .direction = {0, 0, 1}}).is_miss());
  EXPECT_TRUE(traced.largest_value({.origin = {4.5, 4.5, -1}, .direction = {0, 0, 1}}).is_miss());
  EXPECT_EQ(traced.largest_value({.origin = {6, 4.5, -1}, .direction = {0, 0, 1}}).value, 1);
}

TEST(GridLargestValue, never_needs_more_of_the_queue_than_is_reserved) {
  TracedDataset traced(volume_of<double>({30, 25, 37}, noise(1000, 0)), {.macro_factor = 2, .macro_level_count = 4});
  traced.largest_value({.origin = {-1, 3, 3}, .direction = {1, 0, 0}});
  const std::size_t capacity = traced.scratch.queue.capacity();
  for (const Ray& ray : stressful_rays({29, 24, 36}, 2000, 5)) traced.largest_value(ray, Method{}, true, false);
  EXPECT_EQ(traced.scratch.queue.capacity(), capacity);
}

}  // namespace
}  // namespace rhoray::tests
