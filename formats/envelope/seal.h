#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

namespace rhoray::formats::envelope {

inline constexpr std::uint64_t seal_bytes = 64;
inline constexpr std::uint64_t block_bytes = 65536;  ///< bytes of the data area per checksum

constexpr std::uint64_t block_count(std::uint64_t data_bytes) {
  return data_bytes / block_bytes + (data_bytes % block_bytes != 0 ? 1 : 0);
}

using Seal = std::array<std::byte, seal_bytes>;

/// The last 64 bytes of a file: magic | file size | block size | XXH3-128(header) | XXH3-128(sums)
/// | XXH3-64(the 56 bytes before).
/// @param header  bytes 0 .. 8+N
/// @param sums    the bytes of "_sum"
Seal make_seal(std::uint64_t file_bytes, std::span<const std::byte> header, std::span<const std::byte> sums);

/// The checks of a seal, in the order in which a reader can run them. Each refuses on failure;
/// `file` is the name for messages.
void check_seal_itself(std::string_view file, std::span<const std::byte, seal_bytes> seal, std::uint64_t file_bytes);
void check_sealed_header(std::string_view file, std::span<const std::byte, seal_bytes> seal,
                         std::span<const std::byte> header);
void check_sealed_sums(std::string_view file, std::span<const std::byte, seal_bytes> seal,
                       std::span<const std::byte> sums);

/// A byte range of a file, read from a descriptor.
struct Stretch {
  int descriptor = -1;
  std::uint64_t first_byte = 0;
  std::uint64_t byte_count = 0;
};

/// Reads a byte range once and calls act(block, XXH3-64 of it) for every 64 KiB, from several
/// threads, in no promised order. The sum is nothing where the system cannot read the bytes (a
/// failing disk, a file truncated meanwhile). Reading through the descriptor reports such a
/// failure, where a mapping would end the process.
void sum_blocks(const Stretch& stretch, unsigned threads,
                const std::function<void(std::uint64_t block, std::optional<std::uint64_t> sum)>& act);

}  // namespace rhoray::formats::envelope
