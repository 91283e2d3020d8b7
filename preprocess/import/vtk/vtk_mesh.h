#pragma once

#include <filesystem>

#include "preprocess/import/mesh/mesh_pieces.h"

namespace rhoray::preprocess {

/// Adds the pieces of a VTU file to `pieces`.
void add_vtu(MeshPieces& pieces, const std::filesystem::path& path);

}  // namespace rhoray::preprocess
