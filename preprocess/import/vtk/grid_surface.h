#pragma once

#include <filesystem>
#include <string>

#include "preprocess/export/stl_file.h"

namespace rhoray::preprocess {

/// Writes the isosurface of a packed grid as STL (content: export_grid.h). Not atomic: a
/// failure may leave an incomplete file at `output`.
StlCounts write_grid_surface(const std::filesystem::path& packed, const std::string& field, double isovalue,
                             const std::filesystem::path& output);

}  // namespace rhoray::preprocess
