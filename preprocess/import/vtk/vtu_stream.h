#pragma once

#include <filesystem>
#include <optional>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Reads a VTU file array by array (vtk_xml_stream.h), with no more of it in memory than the mesh's
/// own arrays. Returns nothing for files that need VTK's reader: several pieces, polyhedra,
/// Lagrange cells, ghost cells, text arrays, and unknown encodings. It reads other files as VTK's
/// reader does, and refuses damage.
std::optional<CellMesh> stream_vtu(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
