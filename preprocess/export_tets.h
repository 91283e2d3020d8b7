#pragma once

#include <optional>

#include "preprocess/export_grid.h"

namespace rhoray::preprocess {

/// Writes a packed mesh as VTU: points in world coordinates, all fields, and the cells' ids as cell
/// field "cell_id".
ExportReport export_vtu(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {});

/// Writes triangles in world axes (binary .stl).
///
/// With an isovalue: the isosurface, one polygon for each tetrahedron that it passes through.
/// Corners lie on edges, where the field takes the isovalue. Cells without data have no polygon.
/// Fronts face lower values.
///
/// Without an isovalue: the mesh's boundary, that is the faces that belong to one cell. Fronts face
/// outwards.
///
/// Refuses a surface that single precision cannot hold (ErrorCode::unsupported).
ExportReport export_tets_stl(const std::filesystem::path& packed, std::optional<double> isovalue,
                             const std::filesystem::path& output, const ExportOptions& options = {});

}  // namespace rhoray::preprocess
