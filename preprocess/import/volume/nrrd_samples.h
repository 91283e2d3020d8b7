#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Where the samples of a NRRD file are, and how they are stored.
struct NrrdSamples {
  struct Part {
    std::filesystem::path file;
    std::size_t begin = 0;  ///< behind the header, if there is one
  };
  std::filesystem::path header;
  std::vector<Part> parts;  ///< one after the other, each with an equal share
  std::string encoding;     ///< raw, ASCII, hex, gzip, bzip2
  std::uint64_t line_skip = 0;
  std::int64_t byte_skip = 0;  ///< -1: the samples are the last bytes
  bool is_big_endian = false;
};

/// Refuses missing sample files, and sizes that they cannot hold, before memory is allocated.
/// @param wanted  bytes of `sample_count` samples
void check_data_size(const NrrdSamples& source, std::uint64_t wanted, std::uint64_t sample_count);

/// True for raw samples, gzip and text. The rest is left to Teem.
bool is_read_here(const NrrdSamples& source);

/// The samples, in native byte order. Refuses numbers in text that the type does not hold, and
/// damage behind the samples; a note says how much is left out. Teem does none of this: it stops at
/// the last sample, and numbers in text wrap around or lose their fraction.
Array<std::byte> load_samples(const NrrdSamples& source, formats::ElementType type, std::uint64_t bytes,
                              std::vector<std::string>& notes);

/// The bytes of raw samples in a file, after what is to be skipped.
std::span<const std::byte> raw_samples(const NrrdSamples& source, const ForeignFile& file, std::size_t begin,
                                       std::uint64_t wanted, std::vector<std::string>& notes);

}  // namespace rhoray::preprocess
