#pragma once

#include <cstdint>
#include <filesystem>

#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// What an OpenVDB file holds, grid by grid, of whatever kind; read in a process of its own.
/// @param memory_limit_bytes  of the reading process; 0 = none
Json vdb_info(const std::filesystem::path& path, std::uint64_t memory_limit_bytes);

/// One line for people about one of its "grids".
std::string grid_text(const Json& grid);

}  // namespace rhoray::tools
