#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Bytes read piece by piece from memory that outlives the stream: plain, or unpacked on the way
/// when they begin as gzip or zlib data do and `may_be_packed`.
class ByteStream {
 public:
  ByteStream(const std::filesystem::path& path, std::span<const std::byte> source, bool may_be_packed);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  bool is_packed() const { return inflater_ != nullptr; }

  /// Fills `bytes` from the next ones; refuses when they end first or are damaged.
  void read(std::span<std::byte> bytes, std::string_view what);

  /// Reads up to `most` bytes more and returns how many there were. At the end of a packed stream
  /// its own checksum is verified.
  std::uint64_t drain(std::uint64_t most);

 private:
  struct Inflater;
  std::uint64_t read_some(std::span<std::byte> bytes);
  std::uint64_t read_packed(std::span<std::byte> bytes);

  std::filesystem::path path_;
  std::span<const std::byte> rest_;  ///< not yet read, or not yet given to zlib
  std::size_t source_bytes_;
  std::unique_ptr<Inflater> inflater_;
};

}  // namespace rhoray::preprocess
