#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/kernels/kernels.h"
#include "render/kernels/wide/blockers.h"
#include "render/volumes/occupancy.h"

namespace rhoray::render::wide {

/// How steep the field is in the cells that a grid's isosurface passes through, block by block of 4 x 4 x 4 cells.
class BlockSlopes {
 public:
  /// Of the cells of one block that have corners on both sides.
  struct Block {
    float cell_low[3], cell_high[3];  ///< the box around them, in cells
    float least[3], greatest[3];      ///< along each axis the differences of corners beside each other, outward
  };

  /// @param question  of which the wide kernel of grids finds crossings, as far as the volume is a grid
  /// @return          null of other volumes, where that kernel leaves the answer to others, and where data have gaps:
  ///                  from one side of a gap to the other the field may rise in no cell
  static std::shared_ptr<const BlockSlopes> of(const VolumeImplementation& volume, const Question& question,
                                               unsigned threads);

  std::span<const Block> blocks() const { return blocks_; }
  const std::shared_ptr<const Occupancy>& occupancy() const { return occupancy_; }  ///< of which these are the blocks

 private:
  std::shared_ptr<const Occupancy> occupancy_;
  std::vector<Block> blocks_;
};

/// Those found last. Not for two threads at once.
class BlockSlopesMemory {
 public:
  std::shared_ptr<const BlockSlopes> of(const VolumeImplementation& volume, const Question& question, unsigned threads);

 private:
  static constexpr std::size_t most_kept = 4;
  std::vector<std::shared_ptr<const BlockSlopes>> kept_;  ///< newest first
};

/// As facet_blockers_of, of a grid: a block through which the field falls along all rays to the light, whichever of its
/// cells they pass, holds nothing back from rays that start below the isovalue. Of a light that stands in one
/// direction.
std::array<std::shared_ptr<const Blockers>, 2> grid_blockers_of(const BlockSlopes& slopes, const LightPlace& light);

}  // namespace rhoray::render::wide
