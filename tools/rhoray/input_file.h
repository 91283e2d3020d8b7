#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace rhoray::tools {

/// Refuses a path that is not a readable file, nor a folder that is read as one volume (ErrorCode::unreadable), with
/// the nearest name in its folder. A pipe or a device is no file: reading it might never end.
void require_input(const std::filesystem::path& path);

/// "x.npz: unsupported file type ".npz"", for a file that no reader knows.
std::string unsupported_type(const std::filesystem::path& path);

/// Bytes of a file, or of all files that stand in a folder.
std::uintmax_t input_bytes(const std::filesystem::path& path);

}  // namespace rhoray::tools
