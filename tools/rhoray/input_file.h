#pragma once

#include <filesystem>

namespace rhoray::tools {

/// Refuses a path that is not a readable file (Trouble::unreadable), with the nearest name in its folder.
void require_input(const std::filesystem::path& path);

}  // namespace rhoray::tools
