#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "formats/macro_ranges.h"
#include "render/query/last_isovalues.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Which blocks of 4 x 4 x 4 leaf cells an isosurface can pass through: one bit per block, in trees
/// of 64 children per node, built from a grid's macro levels of factor 4.
///
///     nodes        one per 16^3 cells: bit x + 4 y + 16 z, 0 to 3 each, for its block (x, y, z)
///     super nodes  one per 64^3 cells: the same for its nodes, set where a node has a bit
///
/// A bit is set where the block's values lie on both sides of the isovalue. Where it is clear, the
/// surface cannot pass through the block. Bits of blocks beyond the last cells are clear.
class Occupancy {
 public:
  /// Children of macrocells whose values lie on one side are not read.
  /// @param stop  ends it (ErrorCode::interrupted)
  Occupancy(const formats::MacroRanges& ranges, double isovalue, const std::stop_token& stop = {});

  /// Nodes per axis, a multiple of 4.
  const std::array<int, 3>& node_count() const { return node_count_; }

  const std::uint64_t* nodes() const { return nodes_.data(); }  ///< x fastest
  /// x fastest, node_count() / 4 per axis.
  const std::uint64_t* super_nodes() const { return super_nodes_.data(); }

  /// Boxes, in cells, around all blocks that have a bit. They enclose single blocks where these are
  /// few, else the blocks of a node, or those of a super node.
  const BoxLevels& boxes() const { return boxes_; }

  std::size_t size_bytes() const;

 private:
  template <class T>
  void find_nodes(const formats::MacroRanges& ranges, double isovalue, const std::stop_token& stop);
  void find_boxes(const Index3& leaf_count);

  std::array<int, 3> node_count_;
  std::vector<std::uint64_t> nodes_, super_nodes_;
  BoxLevels boxes_;
};

/// Keeps the occupancies of one volume for the isovalues used last. Thread-safe.
class OccupancyCache {
 public:
  std::shared_ptr<const Occupancy> of(const formats::MacroRanges& ranges, double isovalue,
                                      const std::stop_token& stop = {}) {
    return last_.of(isovalue, stop, [&] { return std::make_shared<const Occupancy>(ranges, isovalue, stop); });
  }

  std::size_t size_bytes() {
    return last_.sum([](const Occupancy& occupancy) { return occupancy.size_bytes(); }, [] { return std::size_t{0}; });
  }
  void clear() {
    last_.clear([] {});
  }

 private:
  LastIsovalues<Occupancy> last_;
};

}  // namespace rhoray::render
