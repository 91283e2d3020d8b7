#include "preprocess/mesh/leaf_lists/build_leaf_lists.h"

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "formats/base/parallel.h"
#include "preprocess/mesh/leaf_lists/touched_leaves.h"

namespace rhoray::preprocess {
namespace {

/// Calls act(cell, leaf) for every leaf cell that a cell touches, on all threads.
template <class Act>
void for_each_touch(std::span<const std::array<double, 3>> points, std::span<const std::array<std::uint32_t, 4>> cells,
                    const formats::LeafLattice& lattice, ProgressMeter& meter, const Act& act) {
  const Index3 count = lattice.macro.leaf_count;
  // Ranges are large because threads at neighbouring cells would count in the same cache lines.
  parallel_for(cells.size(), 1 << 14, [&](const IndexRange& part) {
    TouchedLeaves touched(lattice);
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      const auto& cell = cells[c];
      touched.for_each_row({points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]},
                           [&](std::int64_t i_first, std::int64_t i_last, std::int64_t j, std::int64_t k) {
                             const std::int64_t row = (k * count.y + j) * count.x;
                             for (std::int64_t i = i_first; i <= i_last; ++i) act(c, static_cast<std::size_t>(row + i));
                           });
    }
    meter.add(part.size());
  });
}

}  // namespace

LeafLists build_leaf_lists(std::span<const std::array<double, 3>> points,
                           std::span<const std::array<std::uint32_t, 4>> cells, const formats::LeafLattice& lattice,
                           const Progress& progress) {
  LeafLists lists;
  const auto leaf_count = static_cast<std::size_t>(volume(lattice.macro.leaf_count));
  lists.offsets.assign(leaf_count + 1, 0);

  // Count, sum up to the end of each list, then fill lists from their ends: the offsets are then
  // their beginnings.
  ProgressMeter counting(progress, "measuring leaf lists (cells)", cells.size());
  for_each_touch(points, cells, lattice, counting, [&](std::size_t, std::size_t leaf) {
    std::atomic_ref(lists.offsets[leaf]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::size_t leaf = 1; leaf <= leaf_count; ++leaf) lists.offsets[leaf] += lists.offsets[leaf - 1];
  lists.items.resize(lists.offsets.back());
  ProgressMeter filling(progress, "sorting cells into leaf lists (cells)", cells.size());
  for_each_touch(points, cells, lattice, filling, [&](std::size_t cell, std::size_t leaf) {
    const std::uint64_t end = std::atomic_ref(lists.offsets[leaf]).fetch_sub(1, std::memory_order_relaxed);
    lists.items[end - 1] = static_cast<std::uint32_t>(cell);
  });

  // Threads filled a list in any order. Sorted, it is the same for any number of threads.
  parallel_for(leaf_count, 1024, [&](const IndexRange& part) {
    for (std::size_t leaf = part.begin(); leaf < part.end(); ++leaf)
      std::sort(lists.items.begin() + static_cast<std::ptrdiff_t>(lists.offsets[leaf]),
                lists.items.begin() + static_cast<std::ptrdiff_t>(lists.offsets[leaf + 1]));
  });
  return lists;
}

}  // namespace rhoray::preprocess
