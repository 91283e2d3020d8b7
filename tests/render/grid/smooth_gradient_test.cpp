#include "render/grid/smooth_gradient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <variant>

#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::CellSurroundings;
using render::RectilinearGrid;
using render::UniformGrid;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// x^2 - 2 y^2 + 3 z^2 + x y - 2 y z + 4 z x + x, without the parts that an axis does not see.
double quadratic(const Vec3& p) {
  return p.x * p.x - 2 * p.y * p.y + 3 * p.z * p.z + p.x * p.y - 2 * p.y * p.z + 4 * p.z * p.x + p.x;
}
Vec3 gradient_of_quadratic(const Vec3& p) {
  return {2 * p.x + p.y + 4 * p.z + 1, -4 * p.y + p.x - 2 * p.z, 6 * p.z - 2 * p.y + 4 * p.x};
}

Vec3 position(const Index3& at) {
  return {static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)};
}

template <class Grid>
Vec3 gradient_at(const Grid& grid, const Index3& cell, const Vec3& place) {
  CellSurroundings around;
  render::surroundings_reader(grid)(grid, cell, around);
  return smooth_gradient(grid.geometry(), cell, place, around);
}

/// Whole numbers from 0 to 6.
template <class T>
preprocess::NeutralVolume noise_volume(const Index3& count) {
  Dice dice(20261126);
  return volume_of<T>(count, [&](const Index3&) { return static_cast<T>(dice.below(7)); });
}

const UniformGrid& uniform(const TracedDataset& traced) {
  return std::get<UniformGrid>(traced.dataset().implementation().view);
}

// The gradient of a quadratic polynomial is linear: interpolating it changes nothing.
TEST(SmoothGradient, of_a_quadratic_polynomial_is_its_own) {
  const TracedDataset traced(volume_of<double>({9, 8, 7}, [](const Index3& at) { return quadratic(position(at)); }));
  Dice dice(1);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = dice.point({1, 1, 1}, {7, 6, 5});
    const Index3 cell(static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y), static_cast<std::int64_t>(p.z));
    EXPECT_LT((gradient_at(uniform(traced), cell, p - position(cell)) - gradient_of_quadratic(p)).length(), 1e-11);
  }
}

TEST(SmoothGradient, of_a_quadratic_polynomial_is_its_own_between_uneven_planes) {
  Axes axes{{{-5}, {0}, {1}}};
  for (int i = 1; i < 9; ++i) {
    axes[0].push_back(axes[0].back() + (i % 3 == 0 ? 4 : 1));
    axes[1].push_back(axes[1].back() + std::pow(1.3, i));
    axes[2].push_back(std::sqrt(1 + 7.0 * i * i));
  }
  auto volume = volume_of<double>({9, 9, 9}, [&](const Index3& at) { return quadratic(position_of(axes, at)); });
  volume.axes = axes;
  const TracedDataset traced(volume);
  const auto& grid = std::get<RectilinearGrid>(traced.dataset().implementation().view);
  Dice dice(2);
  for (int i = 0; i < 500; ++i) {
    const Vec3 of_cells = dice.point({1, 1, 1}, {7, 7, 7});
    const Index3 cell(static_cast<std::int64_t>(of_cells.x), static_cast<std::int64_t>(of_cells.y),
                      static_cast<std::int64_t>(of_cells.z));
    const Vec3 share = of_cells - position(cell);
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& table = axes[static_cast<std::size_t>(axis)];
      const auto low = static_cast<std::size_t>(cell[axis]);
      p[axis] = table[low] + share[axis] * (table[low + 1] - table[low]);
    }
    EXPECT_LT((gradient_at(grid, cell, share) - gradient_of_quadratic(p)).length(),
              1e-12 * gradient_of_quadratic(p).length() + 1e-9);
  }
}

TEST(SmoothGradient, of_a_linear_field_is_the_exact_one_up_to_the_border) {
  const Vec3 slope(3, -2, 0.5);
  const TracedDataset traced(
      volume_of<float>({6, 5, 4}, [&](const Index3& at) { return static_cast<float>(slope.dot(position(at))); }));
  Dice dice(3);
  Index3 cell;
  for (cell.z = 0; cell.z < 3; ++cell.z)
    for (cell.y = 0; cell.y < 4; ++cell.y)
      for (cell.x = 0; cell.x < 5; ++cell.x)
        EXPECT_LT((gradient_at(uniform(traced), cell, dice.point({0, 0, 0}, {1, 1, 1})) - slope).length(), 1e-12);
}

/// Expects the same gradient on both sides of all faces between cells, and jumps of the exact one.
template <class T>
void expect_continuity(const preprocess::PackVolumeOptions& options) {
  const TracedDataset traced(noise_volume<T>({11, 9, 10}), options);
  const UniformGrid& grid = uniform(traced);
  Dice dice(4);
  int jumps = 0;
  for (int i = 0; i < 300; ++i) {
    const int axis = i % 3;
    Index3 cell(dice.below(9), dice.below(7), dice.below(8)), next = cell;
    ++next[axis];
    Vec3 end = dice.point({0, 0, 0}, {1, 1, 1}), begin = end;
    end[axis] = 1, begin[axis] = 0;
    EXPECT_EQ(gradient_at(grid, cell, end), gradient_at(grid, next, begin));
    jumps += (grid.cell(cell).gradient(end) - grid.cell(next).gradient(begin)).length() > 1e-3;
  }
  EXPECT_GT(jumps, 250) << "of the exact gradient";
}

TEST(SmoothGradient, is_continuous_across_faces_in_every_layout_and_type) {
  for (const auto order : {preprocess::SampleOrder::linear, preprocess::SampleOrder::bricks}) {
    expect_continuity<std::uint8_t>({.order = order});
    expect_continuity<std::int16_t>({.order = order});
    expect_continuity<float>({.order = order});
    expect_continuity<double>({.order = order});
  }
  expect_continuity<float>({.order = preprocess::SampleOrder::sparse});
}

TEST(SmoothGradient, is_one_sided_where_the_sample_beside_has_no_data) {
  // The field is x^2 for x up to 3; beyond it there are no data.
  const auto squares = volume_of<float>({8, 4, 4}, [](const Index3& at) {
    return static_cast<float>(at.x <= 3 ? static_cast<double>(at.x * at.x) : nan);
  });
  for (const auto order : {preprocess::SampleOrder::bricks, preprocess::SampleOrder::sparse}) {
    const TracedDataset traced(squares, {.order = order, .brick_edge = 2});
    const auto slope_at = [&](std::int64_t cell, double place) {
      const Vec3 gradient = gradient_at(uniform(traced), {cell, 1, 1}, {place, 0.5, 0.5});
      EXPECT_EQ(gradient.y, 0);
      EXPECT_EQ(gradient.z, 0);
      return gradient.x;
    };
    EXPECT_EQ(slope_at(2, 0), 4) << "central";
    EXPECT_EQ(slope_at(2, 1), 5) << "9 - 4";
    EXPECT_EQ(slope_at(0, 0), 1) << "at the border, 1 - 0";
    EXPECT_EQ(slope_at(0, 1), 2) << "central";
  }
}

TEST(SmoothGradient, reads_the_same_samples_through_cells) {
  const TracedDataset traced(noise_volume<float>({7, 6, 5}));
  const UniformGrid& direct = uniform(traced);
  auto parts = render::GridData::Parts{
      .ranges = direct.ranges(),
      .fetch_cell = [](const render::GridData& grid,
                       const Index3& cell) { return static_cast<const UniformGrid*>(grid.memory())->cell(cell); },
      .source = {},
      .values = direct.values(),
      .has_gaps = false,
      .memory = std::shared_ptr<const void>(&direct, [](const void*) {}),
      .packed = {}};
  const UniformGrid by_cells(std::move(parts));
  Index3 cell;
  for (cell.z = 0; cell.z < 4; ++cell.z)
    for (cell.y = 0; cell.y < 5; ++cell.y)
      for (cell.x = 0; cell.x < 6; ++cell.x)
        EXPECT_EQ(gradient_at(by_cells, cell, {0.25, 0.5, 0.875}), gradient_at(direct, cell, {0.25, 0.5, 0.875}));
}

}  // namespace
}  // namespace rhoray::tests
