#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "render/exact/grid_source.h"
#include "tests/render/exact/exact_field.h"
#include "tests/render/support/rays.h"

/// Small grids in memory, and the field along a ray in each of their cells, in exact numbers.
namespace rhoray::tests {

/// Samples in memory; planes at integers or in tables; regions of 2^level cells per axis.
class TestGrid : public render::ExactGridSource {
 public:
  TestGrid(const Index3& cell_count, const std::function<double(double, double, double)>& f) : cells_(cell_count) {
    for (std::int64_t k = 0; k <= cells_.z; ++k)
      for (std::int64_t j = 0; j <= cells_.y; ++j)
        for (std::int64_t i = 0; i <= cells_.x; ++i)
          samples_.push_back(f(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
  }

  Index3 cell_count() const override { return cells_; }
  std::array<double, 8> corners(const Index3& cell) const override {
    std::array<double, 8> result{};
    for (std::size_t c = 0; c < 8; ++c) result[c] = at(cell + Index3(c & 1 ? 1 : 0, c & 2 ? 1 : 0, c & 4 ? 1 : 0));
    return result;
  }
  double plane(int axis, std::int64_t k) const override {
    const auto& table = tables[static_cast<std::size_t>(axis)];
    return table.empty() ? static_cast<double>(k) : table[static_cast<std::size_t>(k)];
  }
  int level_count() const override { return levels; }
  render::CellRegion region(int level, const Index3& cell) const override {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    render::CellRegion region{{}, {}, infinity, -infinity};
    for (int axis = 0; axis < 3; ++axis) {
      region.first[axis] = cell[axis] >> level << level;
      region.end[axis] = std::min(cells_[axis], region.first[axis] + (std::int64_t{1} << level));
    }
    for (std::int64_t k = region.first.z; k <= region.end.z; ++k)
      for (std::int64_t j = region.first.y; j <= region.end.y; ++j)
        for (std::int64_t i = region.first.x; i <= region.end.x; ++i)
          if (const double f = at({i, j, k}); std::isfinite(f)) {
            region.smallest = std::min(region.smallest, f);
            region.largest = std::max(region.largest, f);
          }
    return region;
  }

  double& at(const Index3& s) {
    return samples_[static_cast<std::size_t>(s.x + (cells_.x + 1) * (s.y + (cells_.y + 1) * s.z))];
  }
  double at(const Index3& s) const { return const_cast<TestGrid&>(*this).at(s); }

  int levels = 0;
  std::array<std::vector<double>, 3> tables;

 private:
  Index3 cells_;
  std::vector<double> samples_;
};

inline TestGrid any_grid(Dice& dice, bool whole_values) {
  TestGrid grid({1 + dice.below(4), 1 + dice.below(4), 1 + dice.below(4)}, [&](double, double, double) {
    return whole_values ? static_cast<double>(dice.below(5) - 2) : dice.between(-1, 1);
  });
  if (dice.coin())
    for (int axis = 0; axis < 3; ++axis) {
      auto& table = grid.tables[static_cast<std::size_t>(axis)];
      double at = dice.coin() ? 0 : dice.between(-1, 1);
      for (std::int64_t k = 0; k <= grid.cell_count()[axis]; ++k, at += dice.coin() ? 1 : dice.between(0.01, 2))
        table.push_back(at);
    }
  const Index3 n = grid.cell_count();
  for (std::int64_t holes = dice.below(3) == 0 ? 2 : 0; holes > 0; --holes)
    grid.at({dice.below(n.x + 1), dice.below(n.y + 1), dice.below(n.z + 1)}) =
        dice.coin() ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
  grid.levels = static_cast<int>(dice.below(3));
  return grid;
}

inline Vec3 far_corner(const TestGrid& grid) {
  const Index3 n = grid.cell_count();
  return {grid.plane(0, n.x), grid.plane(1, n.y), grid.plane(2, n.z)};
}

/// The ray's part in one cell and the field along it, in exact numbers.
struct ExactChord {
  Index3 cell;
  Rational in, out;
  bool has_data = false;
  Coefficients difference;  ///< value - isovalue, as a function of t
};

inline bool moves(double d) {
  return std::isfinite(1 / d);
}

/// Tests every cell of the grid, one after the other. Returns those that contain some length of the
/// ray, ordered by where they begin.
inline std::vector<ExactChord> chords_of(const TestGrid& grid, const render::Ray& ray, double isovalue) {
  std::vector<ExactChord> chords;
  const Index3 n = grid.cell_count();
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i) {
        ExactChord chord{.cell = {i, j, k},
                         .in = exact(std::max(ray.t_min, -1e300)),
                         .out = exact(std::min(ray.t_max, 1e300)),
                         .difference = {}};
        bool inside = true, any_moves = false;
        for (int axis = 0; axis < 3; ++axis) {
          const double low = grid.plane(axis, chord.cell[axis]), high = grid.plane(axis, chord.cell[axis] + 1);
          const double o = ray.origin[axis], d = ray.direction[axis];
          if (!moves(d)) {
            const bool last = chord.cell[axis] + 1 == n[axis];
            inside = inside && o >= low && (o < high || (last && o == high));
            continue;
          }
          any_moves = true;
          const Rational a = (exact(low) - exact(o)) / exact(d), b = (exact(high) - exact(o)) / exact(d);
          chord.in = std::max(chord.in, std::min(a, b));
          chord.out = std::min(chord.out, std::max(a, b));
        }
        if (!inside || !any_moves || !(chord.in < chord.out)) continue;
        const auto corner = grid.corners(chord.cell);
        chord.has_data = std::all_of(corner.begin(), corner.end(), [](double f) { return std::isfinite(f); });
        if (chord.has_data)
          chord.difference = cubic_through([&](const Rational& t) {
            const auto place = [&](int axis) {
              const Rational low = exact(grid.plane(axis, chord.cell[axis])),
                             high = exact(grid.plane(axis, chord.cell[axis] + 1));
              const Rational d = moves(ray.direction[axis]) ? exact(ray.direction[axis]) : Rational(0);
              return Rational((exact(ray.origin[axis]) + t * d - low) / (high - low));
            };
            return Rational(field_at(corner, {place(0), place(1), place(2)}) - exact(isovalue));
          });
        chords.push_back(std::move(chord));
      }
  std::sort(chords.begin(), chords.end(), [](const ExactChord& a, const ExactChord& b) { return a.in < b.in; });
  return chords;
}

}  // namespace rhoray::tests
