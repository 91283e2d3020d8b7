#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "formats/packed_file.h"

namespace rhoray::formats {

/// Shape of a hierarchy of macrocells over a lattice of leaf cells (paper, section 3, Fig. 4).
/// Level 0 holds the leaf cells. A macrocell of level l + 1 covers factor^3 cells of level l, or
/// fewer at the upper ends of the axes.
struct MacroShape {
  static constexpr int largest_level_count = 12;

  Index3 leaf_count;        ///< leaf cells per axis
  std::int64_t factor = 4;  ///< per axis and level, 2 to 32
  int level_count = 3;      ///< levels above the leaf cells, 1 to largest_level_count

  Index3 count(int level) const;  ///< cells per axis in a level
  /// Leaf cells per axis in one cell of a level: factor^level.
  std::int64_t cell_edge(int level) const;

  friend bool operator==(const MacroShape&, const MacroShape&) = default;
};

/// Smallest and largest value of every macrocell. A macrocell's interval contains every value that
/// interpolation can reach inside it. The interval is empty (lo > hi) where none of its leaf cells
/// has data.
///
/// Array of one level: [z, y, x, 2], lo before hi, in the type of the values. Levels are views of
/// the packed file.
template <class T>
struct MacroLevelsView {
  MacroShape shape;
  /// first stored level: 1 for grids (leaf cells are read from samples), 0 for leaf lists
  int first_level = 1;
  std::vector<std::span<const T>> ranges;  ///< ranges[l - first_level]: level l

  Interval<T> range(int level, std::int64_t i, std::int64_t j, std::int64_t k) const {
    const Index3 size = shape.count(level);
    const auto at = static_cast<std::size_t>(2 * ((k * size.y + j) * size.x + i));
    const std::span<const T> values = ranges[static_cast<std::size_t>(level - first_level)];
    return {values[at], values[at + 1]};
  }
};

/// Names and shapes of the arrays of levels first_level..level_count: `<prefix>0`, `<prefix>1`, ...
std::vector<ArraySpec> macro_arrays(const MacroShape& shape, int first_level, ElementType type,
                                    const std::string& prefix);

/// Views the levels in `file` under `prefix`. Refuses an array that is missing or has another type
/// or shape.
template <class T>
MacroLevelsView<T> view_macro_levels(const PackedFile& file, const MacroShape& shape, int first_level,
                                     const std::string& prefix);

}  // namespace rhoray::formats
