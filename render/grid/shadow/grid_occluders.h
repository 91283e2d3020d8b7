#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "render/grid/occupancy.h"
#include "render/query/kernels.h"
#include "render/shadow/occluders.h"

namespace rhoray::render::wide {

/// The field in the cells that a grid's isosurface passes through: those with corners on both
/// sides.
class SurfaceCells {
 public:
  struct Cell {
    std::uint8_t place;  ///< index in its block: x + 4 y + 16 z
    /// Height above the isovalue, at x + 2 y + 4 z: integers in the cell's own unit.
    std::int8_t corner[8];
    /// A bit of `place`: corners cannot be expressed as such integers.
    static constexpr std::uint8_t unknown = 64;
  };
  /// 4 x 4 x 4 cells.
  struct Block {
    float corner[3];  ///< the lowest corner, in cells
    std::uint32_t first_cell, cell_count;
  };

  /// @param volume  a grid that is fit (is_fit_grid)
  /// @param stop    ends the search (ErrorCode::interrupted)
  /// @return        null where the wide kernel leaves the query to others, and where data have
  ///   gaps: from one side of a gap to the other the field may rise in no cell
  static std::shared_ptr<const SurfaceCells> of(const LoadedDataset& dataset, const RayQuery& query, unsigned threads,
                                                const std::stop_token& stop = {});

  std::span<const Block> blocks() const { return blocks_; }
  std::span<const Cell> cells() const { return cells_; }

 private:
  std::vector<Block> blocks_;
  std::vector<Cell> cells_;
};

/// Returns those that may occlude rays to a light: a cell through which the field falls along all
/// these rays does not occlude rays that start below the isovalue.
/// @param light  a directional light
std::shared_ptr<const LightOccluders> grid_occluders_of(Machine machine, std::shared_ptr<const SurfaceCells> cells,
                                                        const LightPlace& light);

/// The same for grids without gaps and directional lights.
extern const OccluderSearch grid_occluder_search;

}  // namespace rhoray::render::wide
