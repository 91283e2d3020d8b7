#pragma once

#include <cstdint>
#include <span>

#include "formats/base/vector.h"
#include "formats/macro_levels.h"

namespace rhoray::formats {

/// The lattice of leaf cells into which a tetrahedral mesh is sorted. Leaf (i, j, k) spans low +
/// (i, j, k) * leaf_size to low + (i+1, j+1, k+1) * leaf_size, in the mesh's frame (relative to its
/// origin).
struct LeafLattice {
  Vec3 low;
  Vec3 leaf_size;    ///< positive on every axis
  MacroShape macro;  ///< macro.leaf_count leaf cells, and the levels above
};

/// For each leaf cell, the tetrahedra that touch it (paper, section 4.2, Fig. 7). Those of leaf c
/// are items[offsets[c]] to items[offsets[c + 1] - 1], increasing; c = (k * count.y + j) * count.x
/// + i.
struct LeafListsView {
  /// [leaf cells + 1], never decreasing; the last one is items.size()
  std::span<const std::uint64_t> offsets;
  std::span<const std::uint32_t> items;  ///< cell indices

  std::span<const std::uint32_t> list(std::uint64_t leaf) const {
    return items.subspan(offsets[leaf], offsets[leaf + 1] - offsets[leaf]);
  }
};

}  // namespace rhoray::formats
