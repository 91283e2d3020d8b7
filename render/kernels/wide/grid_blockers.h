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

/// How steep the field is in the cells that a grid's isosurface passes through: those with corners on both sides.
class BlockSlopes {
 public:
  /// Along each axis the differences of the cell's corners beside each other, as whole numbers, outward.
  struct Cell {
    std::uint8_t place;  ///< in its block: x + 4 y + 16 z
    std::int8_t least[3], greatest[3];
  };
  /// 4 x 4 x 4 cells.
  struct Block {
    float corner[3];  ///< the lowest, in cells
    float unit;       ///< of the differences; no number where they are too large
    std::uint32_t first_cell, cell_count;
  };

  /// @param question  of which the wide kernel of grids finds crossings, as far as the volume is a grid
  /// @return          null of other volumes, where that kernel leaves the answer to others, and where data have gaps:
  ///                  from one side of a gap to the other the field may rise in no cell
  static std::shared_ptr<const BlockSlopes> of(const VolumeImplementation& volume, const Question& question,
                                               unsigned threads);

  std::span<const Block> blocks() const { return blocks_; }
  std::span<const Cell> cells() const { return cells_; }
  const std::shared_ptr<const Occupancy>& occupancy() const { return occupancy_; }  ///< of which these are the blocks

 private:
  std::shared_ptr<const Occupancy> occupancy_;
  std::vector<Block> blocks_;
  std::vector<Cell> cells_;
};

/// By side: of rays that start outside, inside.
using BlockersOfSides = std::array<std::shared_ptr<const Blockers>, 2>;

/// As facet_blockers_of, of a grid: a cell through which the field falls along all rays to the light holds nothing back
/// from rays that start below the isovalue. Null unless the light stands in one direction.
BlockersOfSides grid_blockers_of(const BlockSlopes& slopes, const LightPlace& light);

/// What was found last, kept from frame to frame. Not for two threads at once.
class GridBlockersMemory {
 public:
  /// @param question  as for BlockSlopes
  BlockersOfSides of(const VolumeImplementation& volume, const Question& question, const LightPlace& light,
                     unsigned threads);

 private:
  struct OfLight {
    Vec3 towards;
    BlockersOfSides blockers;
  };
  struct Kept {
    std::shared_ptr<const BlockSlopes> slopes;
    std::vector<OfLight> lights;  ///< newest first
  };
  Kept* find(const VolumeImplementation& volume, const Question& question, unsigned threads);

  static constexpr std::size_t most_kept = 4;
  std::vector<Kept> kept_;  ///< newest first
};

}  // namespace rhoray::render::wide
