#pragma once

#include "preprocess/import/mesh/mesh_cells.h"

namespace rhoray::preprocess {

/// The hexahedra between the points of a structured grid, x fastest, in VTK's node order. Refuses a
/// grid with fewer than two points along an axis, and one whose number of points is not
/// `available_points`.
ForeignCells hexahedra_of_grid(const Index3& point_counts, std::uint64_t available_points,
                               const std::filesystem::path& path);

}  // namespace rhoray::preprocess
