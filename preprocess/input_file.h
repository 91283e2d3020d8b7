#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace rhoray::preprocess {

/// What a foreign file holds, judged by its name and, for .vtk, by its header.
enum class ForeignKind { volume, mesh, surface, unknown };
ForeignKind foreign_kind(const std::filesystem::path& path);

/// Lists the extensions of files of that kind, and other inputs of that kind, for messages.
std::string extensions_of(ForeignKind kind);

/// Returns advice, in one sentence, for a file whose format is known by its name but is not read
/// here. Returns an empty string for other files.
std::string advice_on(const std::filesystem::path& path);

/// Refuses a path that is neither a readable file nor a folder that is read as one volume
/// (ErrorCode::unreadable), and names the nearest file. Pipes and devices are refused, because
/// reading them might never end.
void require_input(const std::filesystem::path& path);

/// "x.npz: unsupported file type ".npz"", for a file that no reader knows.
std::string unsupported_type(const std::filesystem::path& path);

/// Bytes of a file, or of all files in a folder.
std::uintmax_t input_bytes(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
