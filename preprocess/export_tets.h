#pragma once

#include <optional>

#include "preprocess/export_grid.h"

namespace rhoray::preprocess {

/// A packed mesh as VTU: points in world coordinates, all fields, and the cells' ids as cell field "cell_id".
ExportReport export_vtu(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {});

/// Triangles in world axes (binary .stl). With an isovalue: its surface, one polygon for each tetrahedron that it
/// passes through, corners where the field takes the isovalue on edges; none in cells without data; fronts towards
/// lower values. Without: the mesh's own surface, the faces that belong to one cell, fronts outwards.
ExportReport export_tets_stl(const std::filesystem::path& packed, std::optional<double> isovalue,
                             const std::filesystem::path& output, const ExportOptions& options = {});

}  // namespace rhoray::preprocess
