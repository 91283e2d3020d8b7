#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Reads bytes piece by piece from memory, which must outlive the stream. If `may_be_packed`, data
/// that begins like gzip or zlib is decompressed while reading.
class ByteStream {
 public:
  ByteStream(const std::filesystem::path& path, std::span<const std::byte> source, bool may_be_packed);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  bool is_packed() const { return inflater_ != nullptr; }

  /// Fills `bytes` with the next ones; refuses if the data ends too early or is damaged.
  void read(std::span<std::byte> bytes, std::string_view what);

  /// Reads up to `most` more bytes and returns their number. At the end of a compressed stream its
  /// own checksum is verified.
  std::uint64_t drain(std::uint64_t most);

  /// Reads on to the end, and returns the number of bytes. A checksum further back than the last
  /// byte that anybody wants is verified too.
  std::uint64_t finish();

 private:
  struct Inflater;
  std::uint64_t read_some(std::span<std::byte> bytes);
  std::uint64_t read_packed(std::span<std::byte> bytes);

  std::filesystem::path path_;
  std::span<const std::byte> rest_;  ///< not yet read, or not yet passed to zlib
  std::size_t source_bytes_;
  std::unique_ptr<Inflater> inflater_;
};

/// The file, or the content of a file whose name ends in .gz. Refuses one that gzip did not write.
ForeignFile unpacked_file(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
