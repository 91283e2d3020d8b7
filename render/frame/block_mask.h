#pragma once

#include <cstdint>
#include <vector>

#include "render/frame/box_projection.h"
#include "render/frame/clip_region.h"
#include "render/frame/pixel_lattice.h"
#include "render/frame/tiles.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Columns and rows of blocks, from first to last.
struct BlockRange {
  int first_column, last_column, first_row, last_row;

  bool is_single() const { return first_column == last_column && first_row == last_row; }
};

/// Which blocks of a lattice's pixels have rays that may meet something.
class BlockMask {
 public:
  /// None.
  explicit BlockMask(const PixelLattice& lattice);

  void add(const BlockRange& range);
  bool has_all_of(const BlockRange& range) const;
  bool is_empty() const;

  /// As Tile::blocks; the tile is one of tiles_in_order.
  std::uint16_t of_tile(const Tile& tile) const;

 private:
  /// Calls act(word, bits) for every word that has blocks of a range.
  template <class Words, class Act>
  static void for_each_word(Words& words, std::size_t words_across, const BlockRange& range, const Act& act);

  std::size_t words_across_;
  std::vector<std::uint64_t> words_;  ///< a bit for each block, row by row
};

/// Adds the blocks of which some ray may meet a box; of a projection that is certain.
/// @param clip  where given, boxes of which it leaves nothing do not count
void add_blocks_that_may_meet(const SurfaceBoxes& boxes, const BoxProjection& projection, const PixelLattice& lattice,
                              BlockMask& mask, const ClipRegion::InFrame* clip = nullptr);

}  // namespace rhoray::render
