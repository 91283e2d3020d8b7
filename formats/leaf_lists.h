#pragma once

#include <cstdint>
#include <span>

#include "formats/base/vector.h"
#include "formats/macro_levels.h"

namespace rhoray::formats {

/// The lattice of leaf cells that a tetrahedral mesh is sorted into: leaf (i, j, k) spans low + (i,
/// j, k) * leaf_size to low + (i+1, j+1, k+1) * leaf_size, in the mesh's own frame (relative to its
/// origin).
struct LeafLattice {
  Vec3 low;
  Vec3 leaf_size;    ///< positive on every axis
  MacroShape macro;  ///< macro.leaf_count leaf cells, and the levels above them
};

/// For each leaf cell the tetrahedra that touch it (paper, section 4.2, Fig. 7): those of leaf c
/// are items[offsets[c]] to items[offsets[c + 1] - 1], rising; c = (k * count.y + j) * count.x + i.
struct LeafListsView {
  /// leaf cells + 1, never falling, the last one = items.size()
  std::span<const std::uint64_t> offsets;
  std::span<const std::uint32_t> items;  ///< positions in the array of cells

  std::span<const std::uint32_t> list(std::uint64_t leaf) const {
    return items.subspan(offsets[leaf], offsets[leaf + 1] - offsets[leaf]);
  }
};

}  // namespace rhoray::formats
