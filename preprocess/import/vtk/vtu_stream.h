#pragma once

#include <filesystem>
#include <optional>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Reads a VTU file array by array (vtk_xml_stream.h): at no time is more of it in memory than the
/// arrays of the mesh itself. Nothing for files that VTK's reader is needed for: several pieces,
/// polyhedra, Lagrange cells, ghost cells, arrays of texts, and encodings that are not known. What
/// it does take, it reads as VTK's reader does; damage is refused.
std::optional<CellMesh> stream_vtu(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
