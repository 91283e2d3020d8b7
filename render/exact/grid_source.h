#pragma once

#include <array>
#include <cstdint>

#include "formats/base/vector.h"

namespace rhoray::render {

/// Some cells of a grid, a box of them, and the range of the values at their corners. Corners without data do not
/// count; smallest > largest says that there are no others.
struct CellRegion {
  Index3 first, end;  ///< first <= cell < end on every axis
  double smallest = 0, largest = 0;

  bool is_empty() const { return smallest > largest; }
};

/// A grid as the judge asks for it.
class ExactGridSource {
 public:
  virtual ~ExactGridSource() = default;

  virtual Index3 cell_count() const = 0;

  /// Corner (i, j, k) at position i + 2 j + 4 k. A cell with a corner that is NaN or infinite is absent.
  virtual std::array<double, 8> corners(const Index3& cell) const = 0;

  /// Where a plane between cells stands, 0 <= plane <= cell count: finite, rising strictly.
  virtual double plane(int axis, std::int64_t plane) const = 0;

  /// Levels 1 ... level_count of ever larger regions, which need not be there: they let the judge pass by many cells at
  /// once, and change no verdict.
  virtual int level_count() const { return 0; }
  virtual CellRegion region(int /*level*/, const Index3& cell) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {cell, cell + Index3(1, 1, 1), -infinity, infinity};
  }
};

}  // namespace rhoray::render
