#pragma once

#include <cstdint>
#include <vector>

#include "render/frame/box_projection.h"
#include "render/frame/clip_region.h"
#include "render/frame/pixel_lattice.h"
#include "render/frame/tiles.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Columns and rows of blocks, both ends included.
struct BlockRange {
  int first_column, last_column, first_row, last_row;

  bool is_single() const { return first_column == last_column && first_row == last_row; }
};

/// Blocks of a lattice's pixels whose rays may meet something.
class BlockMask {
 public:
  /// Empty mask.
  explicit BlockMask(const PixelLattice& lattice);

  void add(const BlockRange& range);
  bool has_all_of(const BlockRange& range) const;
  bool is_empty() const;

  /// Bits as in Tile::blocks; the tile must come from tiles_in_order.
  std::uint16_t of_tile(const Tile& tile) const;

 private:
  /// Calls act(word, bits) for every word that contains blocks of the range.
  template <class Words, class Act>
  static void for_each_word(Words& words, std::size_t words_across, const BlockRange& range, const Act& act);

  std::size_t words_across_;
  std::vector<std::uint64_t> words_;  ///< one bit per block, row by row
};

/// Adds the blocks in which some ray may meet a box. The projection must be certain. The blocks are
/// the same on every machine.
/// @param clip  if given, boxes that it removes completely are skipped
void add_blocks_that_may_meet(const SurfaceBoxes& boxes, const BoxProjection& projection, const PixelLattice& lattice,
                              BlockMask& mask, Machine machine, const ClipRegion::InFrame* clip = nullptr);

}  // namespace rhoray::render
