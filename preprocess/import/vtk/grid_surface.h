#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace rhoray::preprocess {

/// Writes the isosurface of a packed grid as STL (export_grid.h says what is in it). Returns the
/// number of triangles. Not atomic by itself; `output` must not matter when it fails.
std::uint64_t write_grid_surface(const std::filesystem::path& packed, const std::string& field, double isovalue,
                                 const std::filesystem::path& output);

}  // namespace rhoray::preprocess
