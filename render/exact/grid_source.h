#pragma once

#include <array>
#include <cstdint>

#include "formats/base/vector.h"

namespace rhoray::render {

/// A box of cells of a grid, and the range of the values at their corners. Corners without data do
/// not count; smallest > largest means that there are no others.
struct CellRegion {
  Index3 first, end;  ///< first <= cell < end on every axis
  double smallest = 0, largest = 0;

  bool is_empty() const { return smallest > largest; }
};

/// A grid as the input of exact arithmetic.
class ExactGridSource {
 public:
  virtual ~ExactGridSource() = default;

  virtual Index3 cell_count() const = 0;

  /// Returns the corner values; corner (i, j, k) is at index i + 2 j + 4 k. A cell with a corner
  /// that is NaN or infinite is absent.
  virtual std::array<double, 8> corners(const Index3& cell) const = 0;

  /// Returns the position of a plane between cells, 0 <= plane <= cell count: finite and strictly
  /// increasing.
  virtual double plane(int axis, std::int64_t plane) const = 0;

  /// Levels 1 ... level_count of increasingly large regions; optional. They allow many cells to be
  /// skipped at once, and change no verdict.
  virtual int level_count() const { return 0; }
  virtual CellRegion region(int /*level*/, const Index3& cell) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {cell, cell + Index3(1, 1, 1), -infinity, infinity};
  }
};

}  // namespace rhoray::render
