#pragma once

#include "formats/vdb_grid.h"
#include "render/grid/grid_data.h"

namespace rhoray::render {

/// A NanoVDB grid as the kernels read it, in its own frame: the first sample of its box lies at
/// position (0, 0, 0). Voxels that are not stored have the value of the tile or the background
/// around them.
///
/// Its samples can be addressed directly where LeafBricks finds slots, and where the macrocells of
/// the lowest level are no larger than a leaf node.
///
/// Builds the macro levels from the leaf nodes; where the grid is sparse this costs little. Refuses
/// a buffer that is not a float grid, or whose nodes do not lie in it.
UniformGrid nanovdb_data(const formats::VdbGrid& grid);

}  // namespace rhoray::render
