#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace rhoray::tools {

/// Refuses a path that is neither a readable file nor a folder that is read as one volume
/// (ErrorCode::unreadable), and names the nearest file. Pipes and devices are refused, because
/// reading them might never end.
void require_input(const std::filesystem::path& path);

/// "x.npz: unsupported file type ".npz"", for a file that no reader knows.
std::string unsupported_type(const std::filesystem::path& path);

/// Bytes of a file, or of all files in a folder.
std::uintmax_t input_bytes(const std::filesystem::path& path);

}  // namespace rhoray::tools
