#include "formats/envelope/seal.h"

#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/base/text.h"
#include "formats/format_error.h"

namespace rhoray::formats::envelope {
namespace {

/// As in PNG: bytes that text-mode transfers and seven-bit channels would change.
constexpr std::array<unsigned char, 8> magic{0x89, 'R', 'H', 'O', '\r', '\n', 0x1a, '\n'};

// Byte offsets in the seal.
constexpr std::size_t file_bytes_at = 8, block_bytes_at = 16, header_sum_at = 24, sums_sum_at = 40, own_sum_at = 56;

void put(Seal& seal, std::size_t at, std::uint64_t value) {
  std::memcpy(seal.data() + at, &value, sizeof value);
}

/// Low half first, like all numbers in the file.
void put(Seal& seal, std::size_t at, XXH128_hash_t sum) {
  put(seal, at, sum.low64);
  put(seal, at + 8, sum.high64);
}

std::uint64_t get(std::span<const std::byte, seal_bytes> seal, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, seal.data() + at, sizeof value);
  return value;
}

bool matches(std::span<const std::byte, seal_bytes> seal, std::size_t at, std::span<const std::byte> bytes) {
  const XXH128_hash_t sum = XXH3_128bits(bytes.data(), bytes.size());
  return get(seal, at) == sum.low64 && get(seal, at + 8) == sum.high64;
}

/// True when all bytes were read.
bool read_fully(int descriptor, std::span<std::byte> target, std::uint64_t first_byte) {
  while (!target.empty()) {
    const ssize_t got = ::pread(descriptor, target.data(), target.size(), static_cast<off_t>(first_byte));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    target = target.subspan(static_cast<std::size_t>(got));
    first_byte += static_cast<std::uint64_t>(got);
  }
  return true;
}

}  // namespace

Seal make_seal(std::uint64_t file_bytes, std::span<const std::byte> header, std::span<const std::byte> sums) {
  Seal seal{};
  std::memcpy(seal.data(), magic.data(), magic.size());
  put(seal, file_bytes_at, file_bytes);
  put(seal, block_bytes_at, block_bytes);
  put(seal, header_sum_at, XXH3_128bits(header.data(), header.size()));
  put(seal, sums_sum_at, XXH3_128bits(sums.data(), sums.size()));
  put(seal, own_sum_at, XXH3_64bits(seal.data(), own_sum_at));
  return seal;
}

void check_seal_itself(std::string_view file, std::span<const std::byte, seal_bytes> seal, std::uint64_t file_bytes) {
  const std::string place = concat("byte ", file_bytes - seal_bytes);
  if (std::memcmp(seal.data(), magic.data(), magic.size()) != 0)
    refuse(file, place, "no seal", "the seal that ends a complete file; it is cut short, extended or damaged");
  if (get(seal, own_sum_at) != XXH3_64bits(seal.data(), own_sum_at))
    refuse(file, place, "a seal that does not match its checksum", "an undamaged file");
  if (get(seal, file_bytes_at) != file_bytes)
    refuse(file, concat("byte ", file_bytes - seal_bytes + file_bytes_at), concat("a file of ", file_bytes, " bytes"),
           concat(get(seal, file_bytes_at), " bytes"));
  if (get(seal, block_bytes_at) != block_bytes)
    refuse(file, concat("byte ", file_bytes - seal_bytes + block_bytes_at),
           concat("blocks of ", get(seal, block_bytes_at), " bytes"), concat(block_bytes, " bytes"));
}

void check_sealed_header(std::string_view file, std::span<const std::byte, seal_bytes> seal,
                         std::span<const std::byte> header) {
  if (!matches(seal, header_sum_at, header))
    refuse(file, "header", "bytes that do not match their checksum", "an undamaged file");
}

void check_sealed_sums(std::string_view file, std::span<const std::byte, seal_bytes> seal,
                       std::span<const std::byte> sums) {
  if (!matches(seal, sums_sum_at, sums))
    refuse(file, "array '_sum'", "bytes that do not match their checksum", "an undamaged file");
}

void sum_blocks(const Stretch& stretch, unsigned threads,
                const std::function<void(std::uint64_t, std::optional<std::uint64_t>)>& act) {
  // 4 MiB; for fewer, starting a thread costs more than it saves
  constexpr std::uint64_t fewest_blocks_per_thread = 64;
  for_each_range(block_count(stretch.byte_count), fewest_blocks_per_thread, threads,
                 [&](std::uint64_t first, std::uint64_t last) {
                   std::vector<std::byte> buffer(block_bytes);
                   for (std::uint64_t block = first; block < last; ++block) {
                     const std::uint64_t at = block * block_bytes;
                     const std::span bytes = std::span(buffer).first(std::min(block_bytes, stretch.byte_count - at));
                     const bool all = read_fully(stretch.descriptor, bytes, stretch.first_byte + at);
                     act(block, all ? std::optional(XXH3_64bits(bytes.data(), bytes.size())) : std::nullopt);
                   }
                 });
}

}  // namespace rhoray::formats::envelope
