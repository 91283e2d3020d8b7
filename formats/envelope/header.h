#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/file_description.h"

/// The envelope of a packed file (SPEC.md): header, data area, table of checksums, seal.
namespace rhoray::formats::envelope {

inline constexpr std::uint64_t page_bytes = 4096;
inline constexpr std::uint64_t length_bytes = 8;  ///< length of the header, stored before its text
inline constexpr std::uint64_t small_alignment = 64;

// Limits of a header: far above what real files need, low enough that a hostile file costs nothing.
/// including its length field
inline constexpr std::uint64_t largest_header_bytes = std::uint64_t{1} << 20;
inline constexpr std::size_t largest_array_count = 4096;
inline constexpr std::size_t largest_rank = 8;
inline constexpr std::size_t largest_name_bytes = 256;

inline constexpr std::string_view major_version = "1";
inline constexpr std::string_view start_text = R"({"__metadata__":{"format":"rhoray")";
inline constexpr std::string_view sums_name = "_sum";
inline constexpr std::string_view seal_name = "_seal";

struct Header {
  std::string version;
  FileDescription description;
  /// all, in file order; first_byte counts from the start of the data area
  std::vector<ArrayEntry> arrays;
};

/// Reads and checks a header's text: grammar, limits, version, requirements. Arrays must fill the
/// data area without gaps, with "_sum" and "_seal" last. Every other array that is not padding must
/// start at a multiple of 64.
/// @param file  name for messages
Header read_header(std::string_view file, std::string_view text, std::uint64_t data_bytes);

/// Assigns offsets to declared arrays and adds padding between them, and "_sum" and "_seal" at the
/// end. Throws ErrorCode::usage when the sizes do not fit in 63 bits.
/// @param file  name for messages
std::vector<ArrayEntry> place_arrays(std::string_view file, const std::vector<ArraySpec>& arrays);

/// The header as stored in the file: length, text, spaces up to a multiple of 4096. Throws
/// ErrorCode::usage when it would exceed the limits.
std::string write_header(std::string_view file, const FileDescription& description,
                         const std::vector<ArrayEntry>& arrays);

}  // namespace rhoray::formats::envelope
