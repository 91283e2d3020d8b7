#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace rhoray {

/// Opens an existing file for reading, without ever waiting: reading a pipe would block until
/// somebody writes into it, and a device may never end. Returns a descriptor, closed on exec, that
/// belongs to the caller.
///
/// Refuses (ErrorCode::unreadable) what is missing, not permitted, or not a regular file: a folder,
/// a pipe, a socket or a device. Symbolic links are followed.
int open_regular_file(const std::filesystem::path& path);

/// Refuses as `open_regular_file` does, for a file that a library will open by its name.
void require_regular_file(const std::filesystem::path& path);

/// Up to `count` bytes from the start of a file; fewer where it ends, none where it is not a
/// regular file or cannot be read.
std::string first_bytes(const std::filesystem::path& path, std::size_t count);

}  // namespace rhoray
