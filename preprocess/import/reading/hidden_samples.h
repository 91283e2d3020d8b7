#pragma once

#include <filesystem>
#include <vector>

#include "preprocess/import/reading/point_grid.h"

namespace rhoray::preprocess {

/// Takes VTK's arrays vtkGhostType out of the arrays of a file. They are no fields: they hide
/// points and cells.
std::vector<GridArray> take_ghosts(std::vector<GridArray>& arrays);

/// Sets the samples of hidden points, or of hidden cells and of cells with a hidden point, to NaN,
/// with a note. Integers become floating-point numbers then.
/// @param points    the grid whose points, or cells, have the samples
/// @param in_cells  whether the samples are those of cells
void hide_samples(NeutralVolume& volume, const std::vector<GridArray>& ghosts, const PointGrid& points, bool in_cells,
                  const std::filesystem::path& path);

}  // namespace rhoray::preprocess
