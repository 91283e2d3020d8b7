#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::preprocess {

/// What a foreign file holds, judged by its name and, for .vtk, by its header.
enum class ForeignKind { volume, mesh, surface, unknown };
std::string_view name_of(ForeignKind kind);  ///< "volume"
ForeignKind foreign_kind(const std::filesystem::path& path);

/// A foreign format that is read.
struct ForeignFormat {
  std::string_view name;  ///< "NRRD"
  ForeignKind kind;
  /// Extensions in lower case with their dot, or a kind of folder: "dicom/". Of a format for
  /// several kinds, and of PLOT3D, the content decides too.
  std::vector<std::string_view> families;
  std::string_view worker;         ///< the program that reads it
  bool reads_other_files = false;  ///< the file may name others, or others beside it belong to it
};

/// All formats that are read. importers.cpp has their readers (a test compares the two).
std::span<const ForeignFormat> foreign_formats();

/// Lists the extensions of files of that kind, and other inputs of that kind, for messages.
std::string extensions_of(ForeignKind kind);

/// Returns advice, in one sentence, for a file whose format is known by its name but is not read
/// here. Returns an empty string for other files.
std::string advice_on(const std::filesystem::path& path);

/// The format whose header a file begins with, "NIfTI", also of formats that are not read; empty
/// where none is known, so that the bytes may be samples alone.
std::string_view known_header(const std::filesystem::path& path);

/// Refuses a path that is neither a readable file nor a folder that is read as one volume
/// (ErrorCode::unreadable), and names the nearest file. Pipes and devices are refused, because
/// reading them might never end.
void require_input(const std::filesystem::path& path);

/// "x.npz: unsupported file type ".npz"", for a file that no reader knows.
std::string unsupported_type(const std::filesystem::path& path);

/// Bytes of a file, or of all files in a folder.
std::uintmax_t input_bytes(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
