#pragma once

#include <nanovdb/NanoVDB.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/base/vector.h"
#include "render/grid/sample_source.h"

namespace rhoray::render {

/// The leaf nodes of a NanoVDB tree around a box of voxels, as bricks. Where there is no leaf node,
/// all voxels of a brick have the value of the tile or the background around them.
class LeafBricks {
 public:
  static constexpr std::int64_t edge = nanovdb::NanoLeaf<float>::DIM;

  LeafBricks(const nanovdb::NanoTree<float>& tree, const Index3& first_voxel, const Index3& voxel_count);

  /// Voxel (i, j, k) of the box is sample (i, j, k). Nothing if the leaf nodes are not contiguous
  /// in memory, as OpenVDB's own converter places them.
  std::optional<SampleSource> source() const;

 private:
  using Leaf = nanovdb::NanoLeaf<float>;

  void find_addresses(const Index3& first_voxel, const Index3& voxel_count);
  void find_slots(const nanovdb::NanoTree<float>& tree);

  Index3 low_, count_;  ///< voxel of the first brick; number of bricks
  std::array<std::vector<std::uint64_t>, 3> address_;
  std::vector<std::uint32_t> slots_;
  std::vector<float> values_;
  const Leaf* first_leaf_ = nullptr;
  std::uint32_t leaf_count_ = 0;
};

/// Rounds down to a multiple of a leaf node's edge; also for negative numbers.
constexpr std::int64_t leaf_start(std::int64_t voxel) {
  return voxel & ~(LeafBricks::edge - 1);
}

}  // namespace rhoray::render
