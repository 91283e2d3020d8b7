#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Converts numbers of `element_bytes` bytes to the machine's byte order, in place.
void make_native(std::span<std::byte> bytes, std::size_t element_bytes, bool big_endian);

/// Number of bytes of a volume; refuses an axis below 1 and sizes that do not fit 2^62 bytes.
std::uint64_t checked_volume_bytes(const std::filesystem::path& path, const Index3& sample_count,
                                   formats::ElementType type);

/// The same for colours of 8 bits per component, with 3 or 4 components per texel.
std::uint64_t checked_color_bytes(const std::filesystem::path& path, const Index3& sample_count, int component_count);

inline constexpr std::uint64_t tightest_zlib = 1040;  ///< it compresses to about 1/1032 at best

/// Refuses sizes that a file this short cannot hold even at the best compression.
/// @param tightest  bytes that one packed byte can become at most
void check_packed_size(const std::filesystem::path& path, std::uint64_t wanted_bytes, std::uint64_t file_bytes,
                       std::uint64_t tightest = tightest_zlib);

/// Notes that bytes after the samples were left out, if there are any.
void note_rest(std::vector<std::string>& notes, const std::filesystem::path& path, std::uint64_t bytes);

/// True when numbers of this type are already in the machine's byte order.
bool is_native(formats::ElementType type, bool big_endian);

/// Numbers in native byte order as doubles.
/// @param to  memory for all of them
void copy_as_doubles(formats::ElementType type, std::span<const std::byte> numbers, double* to);

/// The `wanted` bytes of samples behind the first `skipped`. Refuses a file that ends before.
std::span<const std::byte> samples_behind(const std::filesystem::path& path, std::span<const std::byte> source,
                                          std::uint64_t skipped, std::uint64_t wanted);

/// The name of file `number` in a series such as "slice%03d.raw"; nothing if the pattern does not
/// contain exactly one number.
std::optional<std::string> numbered_name(const std::string& pattern, std::int64_t number);

/// The value of a key in a table; nothing if it is not there.
template <class Key, class Value, std::size_t N, class Sought>
std::optional<Value> find_in(const std::pair<Key, Value> (&table)[N], const Sought& sought) {
  for (const auto& [key, value] : table)
    if (key == sought) return value;
  return std::nullopt;
}

void set_samples(NeutralVolume& volume, Array<std::byte> samples);

/// Leaves samples in the file if they already have the wanted form, so that nothing is copied on
/// the way to the packer.
void leave_samples_in(NeutralVolume& volume, const ForeignFile& file, std::span<const std::byte> samples);

/// Last step of every volume reader. Converts 64-bit integers to F64 if every value is exact, and
/// refuses them otherwise. Refuses a map that is not finite or not invertible.
void finish_volume(NeutralVolume& volume, const std::filesystem::path& path);

/// Returns axes along x, y, z with this spacing.
Affine axis_parallel(const Vec3& spacing, const Vec3& origin);

}  // namespace rhoray::preprocess
