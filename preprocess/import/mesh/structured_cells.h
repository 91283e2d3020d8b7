#pragma once

#include "preprocess/import/mesh/mesh_cells.h"

namespace rhoray::preprocess {

/// The hexahedra between the points of a structured grid, x fastest, in VTK's order of nodes.
/// Refuses a grid with fewer than two points along an axis, and one that does not have
/// `available_points`.
ForeignCells hexahedra_of_grid(const Index3& point_counts, std::uint64_t available_points,
                               const std::filesystem::path& path);

}  // namespace rhoray::preprocess
