#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace rhoray {

/// Opens an existing file for reading without ever blocking: reading a pipe would block until
/// somebody writes into it, and a device may never end. Returns a descriptor that is closed on exec
/// and belongs to the caller.
///
/// Refuses (ErrorCode::unreadable) a path that is missing, not permitted, or not a regular file: a
/// folder, a pipe, a socket or a device. Follows symbolic links.
int open_regular_file(const std::filesystem::path& path);

/// Refuses the same files as `open_regular_file`. For a file that a library will open by name.
void require_regular_file(const std::filesystem::path& path);

/// Refuses a path that is not there, that is neither a regular file nor a folder, or that may not
/// be read (ErrorCode::unreadable), and names the nearest file. Reading a pipe or a device might
/// never end.
void require_readable(const std::filesystem::path& path);

/// Returns up to `count` bytes from the start of a file: fewer if the file is shorter, none if it
/// is not a regular file or cannot be read.
std::string first_bytes(const std::filesystem::path& path, std::size_t count);

}  // namespace rhoray
