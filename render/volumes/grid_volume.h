#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "formats/brick_grid.h"
#include "render/cells/trilinear.h"
#include "render/march/lattice_walk.h"

namespace rhoray::render {

/// A packed grid as rays cross it, in its own frame: sample (i, j, k) at position (i, j, k).
template <class T>
class GridVolume {
 public:
  GridVolume(const formats::BrickGrid& grid, std::size_t field)
      : grid_(grid), samples_(grid.samples<T>(field)), levels_(grid.macro_levels<T>(field)) {}

  WalkLattice lattice() const { return {levels_.shape.leaf_count, levels_.shape.factor}; }
  int level_count() const { return levels_.shape.level_count; }
  const formats::GridDescription& description() const { return grid_.description(); }

  /// The values that can occur in a macrocell; level at least 1.
  RHORAY_INLINE Interval<double> range(int level, const Index3& cell) const {
    const Interval<T> stored = levels_.range(level, cell.x, cell.y, cell.z);
    if (stored.is_empty()) return {};
    return {static_cast<double>(stored.lo), static_cast<double>(stored.hi)};
  }

  RHORAY_INLINE TrilinearCell cell(const Index3& c) const {
    const formats::AxisTables& tables = grid_.tables();
    TrilinearCell out;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const std::int64_t i = c.x + static_cast<std::int64_t>(corner & 1),
                         j = c.y + static_cast<std::int64_t>(corner >> 1 & 1),
                         k = c.z + static_cast<std::int64_t>(corner >> 2);
      out.corner[corner] = static_cast<double>(samples_[tables.address(i, j, k)]);
    }
    return out;
  }

  /// False for a cell with a corner that is NaN or infinite; integers always have data.
  RHORAY_INLINE static bool has_data(const TrilinearCell& cell) {
    if constexpr (std::is_floating_point_v<T>)
      return cell.has_data();
    else
      return true;
  }

  RHORAY_INLINE std::uint64_t cell_id(const Index3& c) const {
    const Index3& count = levels_.shape.leaf_count;
    return static_cast<std::uint64_t>((c.z * count.y + c.y) * count.x + c.x);
  }

 private:
  formats::BrickGrid grid_;
  std::span<const T> samples_;
  formats::MacroLevelsView<T> levels_;
};

}  // namespace rhoray::render
