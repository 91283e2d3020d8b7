#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/made_grid.h"

// Grids whose samples are at positions given by tables.
namespace rhoray::tests {
namespace {

using render::Hit;
using render::Method;
using render::Ray;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Steps of 1 and of 1000 side by side, a graded axis, and one with irrational positions.
Axes uneven_axes(const Index3& count) {
  Axes axes{{{-5}, {0}, {1}}};
  for (std::int64_t i = 1; i < count.x; ++i) axes[0].push_back(axes[0].back() + (i % 3 == 0 ? 1000 : 1));
  for (std::int64_t j = 1; j < count.y; ++j) axes[1].push_back(axes[1].back() + std::pow(1.7, static_cast<double>(j)));
  for (std::int64_t k = 1; k < count.z; ++k) axes[2].push_back(std::sqrt(static_cast<double>(1 + 7 * k * k)));
  return axes;
}

/// A volume with samples at the positions in the tables.
preprocess::NeutralVolume rectilinear_volume(const Axes& axes, const Field& field) {
  const Index3 count(static_cast<std::int64_t>(axes[0].size()), static_cast<std::int64_t>(axes[1].size()),
                     static_cast<std::int64_t>(axes[2].size()));
  auto made = volume_of<double>(count, [&](const Index3& at) { return field(position_of(axes, at)); });
  made.axes = axes;
  return made;
}

/// Rays towards points of the box, from outside; every third one starts inside.
std::vector<Ray> rays_through(const Vec3& low, const Vec3& high, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  for (std::size_t r = 0; r < count; ++r) {
    // Directions in units of the box, so that all axes are crossed.
    const Vec3 direction = (dice.direction() * (high - low)).normalized();
    const Vec3 through = dice.point(low, high);
    rays.push_back(
        {.origin = r % 3 == 0 ? through : through - 1.5 * (high - low).length() * direction, .direction = direction});
  }
  return rays;
}

/// Returns the cell that contains a point; nothing within `margin` (of the cell's own edges) of its
/// faces.
std::optional<Index3> cell_holding(const Axes& axes, const Vec3& p, double margin) {
  Index3 cell;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& table = axes[static_cast<std::size_t>(axis)];
    const auto above = std::upper_bound(table.begin(), table.end(), p[axis]);
    cell[axis] = std::clamp<std::int64_t>(above - table.begin() - 1, 0, static_cast<std::int64_t>(table.size()) - 2);
  }
  const Vec3 inside = in_samples(axes, cell, p) - Vec3(cell);
  for (int axis = 0; axis < 3; ++axis)
    if (inside[axis] < margin || inside[axis] > 1 - margin) return std::nullopt;
  return cell;
}

TEST(RectilinearGrid, meets_the_plane_of_a_linear_field_at_its_exact_t) {
  const Axes axes = uneven_axes({17, 12, 21});
  const Vec3 low(axes[0].front(), axes[1].front(), axes[2].front()),
      high(axes[0].back(), axes[1].back(), axes[2].back());
  const Vec3 slope(0.3, -0.7, 0.2);
  TracedDataset traced(rectilinear_volume(axes, linear_field(slope, 1)));
  EXPECT_EQ(traced.dataset().bounds().min, low);
  EXPECT_EQ(traced.dataset().bounds().max, high);
  const double size = (high - low).length();
  int hits = 0, cells = 0;
  for (const Ray& ray : rays_through(low, high, 3000, 1))
    for (const double iso : {0.0, 100.0, 700.0}) {
      const auto part = part_in_box(ray, low, high);
      if (!part) continue;
      const double t = (iso - 1 - slope.dot(ray.origin)) / slope.dot(ray.direction);
      if (std::min(std::abs(t - (*part)[0]), std::abs(t - (*part)[1])) < 1e-6) continue;
      const Hit hit = traced.first_crossing(ray, iso);
      ASSERT_EQ(hit.is_miss(), t < (*part)[0] || t > (*part)[1]);
      if (hit.is_miss()) continue;
      // Rounding error of values of the field's size, divided by the field's slope along the ray.
      EXPECT_NEAR(hit.t, t, 1e-13 * size / std::abs(slope.dot(ray.direction)));
      EXPECT_LT((hit.gradient - slope).length(), 1e-9);
      if (const auto cell = cell_holding(axes, ray.at(t), 1e-6)) {
        EXPECT_EQ(hit.cell, static_cast<std::uint64_t>((cell->z * 11 + cell->y) * 16 + cell->x));
        ++cells;
      }
      ++hits;
    }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(cells, 1500);
}

// Against an independent implementation of the interpolant: zero at the hit, one side before it.
TEST(RectilinearGrid, is_crossed_at_the_first_change_of_side_of_the_interpolant) {
  const Axes axes = uneven_axes({10, 9, 11});
  const Index3 cells(9, 8, 10);
  const Vec3 low = position_of(axes, {0, 0, 0}), high = position_of(axes, cells);
  const Samples samples = [](const Index3& at) {
    return 3 * std::sin(1.3 * static_cast<double>(at.x)) + std::cos(static_cast<double>(at.y + 2 * at.z));
  };
  auto dataset = volume_of<double>({10, 9, 11}, samples);
  dataset.axes = axes;
  TracedDataset traced(dataset, {.macro_factor = 2});
  int hits = 0, judged = 0;
  for (const Ray& ray : rays_through(low, high, 1500, 2)) {
    const Hit hit = traced.first_crossing(ray, 0.4);
    EXPECT_TRUE(same_bits(hit, traced.first_crossing(ray, 0.4, false))) << "hierarchy or not";
    const auto part = part_in_box(ray, low, high);
    if (!part) continue;
    const auto value = [&](double t) -> double {
      const auto cell = cell_holding(axes, ray.at(t), 1e-9);
      return cell ? static_cast<double>(interpolated(samples, *cell, in_samples(axes, *cell, ray.at(t)))) : nan;
    };
    const double start = value((*part)[0] + 1e-7), end = hit.is_miss() ? (*part)[1] : hit.t;
    if (std::isnan(start)) continue;
    for (int i = 1; i < 300; ++i) {
      const double off = value((*part)[0] + (end - (*part)[0]) * i / 300) - 0.4;
      if (std::isnan(off)) continue;
      ASSERT_TRUE((off >= 0) == (start >= 0.4) || std::abs(off) < 1e-8);
      ++judged;
    }
    if (hit.is_miss()) continue;
    if (const double at_hit = value(hit.t); !std::isnan(at_hit)) {
      EXPECT_NEAR(at_hit, 0.4, 1e-8);
    }
    ++hits;
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(judged, 100000);
}

TEST(RectilinearGrid, largest_value_is_what_looking_into_every_cell_finds) {
  const Axes axes = uneven_axes({8, 7, 9});
  const Index3 cells(7, 6, 8);
  const Samples samples = [](const Index3& at) {
    if (at.x == 4 && at.y < 3) return nan;
    const auto hash = static_cast<std::uint64_t>((at.z * 1009 + at.y) * 1013 + at.x + 7) * 0x9e3779b97f4a7c15U;
    return static_cast<double>((hash >> 35) % 1000) - 500;
  };
  auto dataset = volume_of<double>({8, 7, 9}, samples);
  dataset.axes = axes;
  TracedDataset traced(dataset, {.macro_factor = 2});
  int judged = 0;
  for (const Ray& ray : rays_through(position_of(axes, {0, 0, 0}), position_of(axes, cells), 800, 3)) {
    const auto exact = largest_by_brute_force(samples, cells, ray, false, axes);
    const auto face = largest_by_brute_force(samples, cells, ray, true, axes);
    if (!exact) continue;
    EXPECT_NEAR(traced.largest_value(ray).value, *exact, 1e-6);
    EXPECT_NEAR(traced.largest_value(ray, face_rule).value, *face, 1e-6);
    ++judged;
  }
  EXPECT_GT(judged, 700);
}

float speckled(std::int64_t i, std::int64_t j, std::int64_t k) {
  const auto hash = static_cast<std::uint64_t>((k * 1009 + j) * 1013 + i) * 0x9e3779b97f4a7c15U;
  return (hash >> 35) % 20 == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>((hash >> 40) % 7) - 3;
}

std::vector<double> whole_numbers(std::int64_t count) {
  std::vector<double> table;
  for (std::int64_t i = 0; i < count; ++i) table.push_back(static_cast<double>(i));
  return table;
}

TEST(RectilinearGrid, whose_tables_say_whole_numbers_is_the_uniform_grid_bit_for_bit) {
  const Index3 count(20, 18, 23);
  const Axes tables{whole_numbers(count.x), whole_numbers(count.y), whole_numbers(count.z)};
  TracedDataset uniform(made_grid({.sample_count = count}, {{"f", speckled}}).file());
  TracedDataset rectilinear(made_grid({.sample_count = count, .axes = tables}, {{"f", speckled}}).file());
  ASSERT_NE(uniform.dataset().implementation().view.index(), rectilinear.dataset().implementation().view.index());
  int hits = 0;
  for (const Ray& ray : stressful_rays({19, 17, 22}, 2000, 7)) {
    const Hit hit = uniform.first_crossing(ray, 0.5);
    ASSERT_TRUE(same_bits(hit, rectilinear.first_crossing(ray, 0.5)));
    for (const Method& method : {Method{}, face_rule})
      ASSERT_TRUE(same_bits(uniform.largest_value(ray, method), rectilinear.largest_value(ray, method)));
    hits += !hit.is_miss();
  }
  EXPECT_GT(hits, 800);
}

TEST(RectilinearGrid, isosurface_bounds_are_in_the_world) {
  Axes axes{{{}, {}, {}}};
  for (int i = 0; i < 40; ++i)
    for (auto& axis : axes) axis.push_back(static_cast<double>(i * i) / 40);
  const TracedDataset traced(rectilinear_volume(axes, distance_field({20, 20, 20})));
  const Box3 box = traced.dataset().isosurface_bounds(8);
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(box.min[a], 12);
    EXPECT_GE(box.min[a], 4);
    EXPECT_GE(box.max[a], 28);
    EXPECT_LE(box.max[a], 36);
  }
}

TEST(SparseGrid, is_the_dense_grid_bit_for_bit) {
  // Bricks of 4: a slab of them and some single ones have no data.
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    if ((i >= 8 && i < 12 && j < 9) || (i / 4 + j / 4 + k / 4) % 5 == 0) return std::numeric_limits<float>::quiet_NaN();
    return speckled(i, j, k);
  };
  const Index3 count(26, 19, 22);
  for (const Axes& axes : {Axes{}, uneven_axes(count)}) {
    TracedDataset dense(made_grid({.sample_count = count, .axes = axes}, {{"f", value}}).file());
    TracedDataset sparse(made_grid({.sample_count = count, .is_sparse = true, .axes = axes}, {{"f", value}}).file());
    const formats::BrickLayout layout = formats::BrickGrid(sparse.dataset().file()).description().layout;
    EXPECT_LT(layout.stored_brick_count, static_cast<std::uint64_t>(volume(layout.brick_count())));
    const Box3 box = dense.dataset().bounds();
    auto rays = rays_through(box.min, box.max, 1000, 8);
    if (axes[0].empty())
      for (const Ray& ray : stressful_rays({25, 18, 21}, 1000, 9)) rays.push_back(ray);
    int hits = 0;
    for (const Ray& ray : rays) {
      const Hit hit = dense.first_crossing(ray, 0.5);
      ASSERT_TRUE(same_bits(hit, sparse.first_crossing(ray, 0.5)));
      ASSERT_TRUE(same_bits(dense.largest_value(ray), sparse.largest_value(ray)));
      hits += !hit.is_miss();
    }
    EXPECT_GT(hits, 400);
  }
}

}  // namespace
}  // namespace rhoray::tests
