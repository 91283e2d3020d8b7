#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace rhoray::preprocess {

/// Writes the isosurface of a packed grid as STL (content: export_grid.h). Returns the number of
/// triangles. Not atomic: a failure may leave an incomplete file at `output`.
std::uint64_t write_grid_surface(const std::filesystem::path& packed, const std::string& field, double isovalue,
                                 const std::filesystem::path& output);

}  // namespace rhoray::preprocess
