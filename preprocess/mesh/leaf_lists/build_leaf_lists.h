#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/progress.h"
#include "formats/leaf_lists.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct LeafLists {
  Array<std::uint64_t> offsets;  ///< as in formats::LeafListsView
  Array<std::uint32_t> items;

  formats::LeafListsView view() const { return {.offsets = offsets, .items = items}; }
};

/// Sorts the cells into the leaf cells that they touch (leaf_lists/touched_leaves.h).
/// @param points  in the lattice's frame, all inside it
LeafLists build_leaf_lists(std::span<const std::array<double, 3>> points,
                           std::span<const std::array<std::uint32_t, 4>> cells, const formats::LeafLattice& lattice,
                           const Progress& progress = {});

}  // namespace rhoray::preprocess
