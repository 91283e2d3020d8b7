#include "preprocess/import/reading/samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

using formats::ElementType;

namespace {

template <class Word>
void swap_words(std::span<std::byte> bytes) {
  for (std::size_t at = 0; at + sizeof(Word) <= bytes.size(); at += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    if constexpr (sizeof(Word) == 2)
      word = __builtin_bswap16(word);
    else if constexpr (sizeof(Word) == 4)
      word = __builtin_bswap32(word);
    else
      word = __builtin_bswap64(word);
    std::memcpy(bytes.data() + at, &word, sizeof word);
  }
}

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The same numbers as doubles, or nothing if one would change.
template <class T>
std::optional<Array<std::byte>> as_doubles(std::span<const std::byte> bytes) {
  Array<std::byte> result(bytes.size());
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    const auto number = static_cast<double>(value);
    // 2^63 and 2^64 round up out of the integer's range, where casting back would be undefined.
    if (number >= std::ldexp(1.0, std::is_signed_v<T> ? 63 : 64) || static_cast<T>(number) != value)
      return std::nullopt;
    std::memcpy(result.data() + at, &number, sizeof number);
  }
  return result;
}

}  // namespace

bool is_native(ElementType type, bool big_endian) {
  return formats::element_bytes(type) == 1 || big_endian == (std::endian::native == std::endian::big);
}

void make_native(std::span<std::byte> bytes, std::size_t element_bytes, bool big_endian) {
  if (big_endian == (std::endian::native == std::endian::big)) return;
  if (element_bytes == 2) swap_words<std::uint16_t>(bytes);
  if (element_bytes == 4) swap_words<std::uint32_t>(bytes);
  if (element_bytes == 8) swap_words<std::uint64_t>(bytes);
}

std::uint64_t checked_volume_bytes(const std::filesystem::path& path, const Index3& n, ElementType type) {
  const std::string sizes = concat(n.x, " x ", n.y, " x ", n.z, " samples");
  if (n.x < 1 || n.y < 1 || n.z < 1) refuse_input(path, "header", sizes, "at least 1 on each axis");
  const std::optional<std::uint64_t> bytes =
      checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                       static_cast<std::uint64_t>(n.z), formats::element_bytes(type)});
  if (!bytes || *bytes > std::uint64_t{1} << 62) refuse_input(path, "header", sizes, "a size that fits in memory");
  return *bytes;
}

std::uint64_t checked_color_bytes(const std::filesystem::path& path, const Index3& n, int component_count) {
  return checked_volume_bytes(path, n, ElementType::U32) / 4 * static_cast<std::uint64_t>(component_count);
}

void check_packed_size(const std::filesystem::path& path, std::uint64_t wanted_bytes, std::uint64_t file_bytes,
                       std::uint64_t tightest) {
  if (wanted_bytes / tightest > file_bytes)
    refuse_input(path, "header", concat("sizes that need ", wanted_bytes, " bytes, in ", file_bytes, " packed bytes"),
                 "sizes that the packed bytes can hold");
}

void note_rest(std::vector<std::string>& notes, const std::filesystem::path& path, std::uint64_t bytes) {
  if (bytes > 0) notes.push_back(concat(path.string(), ": ", bytes, " bytes after the samples were left out"));
}

void copy_as_doubles(ElementType type, std::span<const std::byte> numbers, double* to) {
  formats::with_element_type(type, [&]<class T>(T) {
    for (std::size_t at = 0; at < numbers.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, numbers.data() + at, sizeof value);
      *to++ = static_cast<double>(value);
    }
  });
}

std::span<const std::byte> samples_behind(const std::filesystem::path& path, std::span<const std::byte> source,
                                          std::uint64_t skipped, std::uint64_t wanted) {
  if (skipped > source.size() || wanted > source.size() - skipped)
    refuse_input(path, concat("byte ", source.size()), "the end of the file",
                 concat(wanted, " bytes of samples after the first ", skipped));
  return source.subspan(skipped, wanted);
}

std::optional<std::string> numbered_name(const std::string& pattern, std::int64_t number) {
  const std::size_t begin = pattern.find('%'), end = pattern.find_first_not_of("0123456789", begin + 1);
  if (begin == pattern.npos || end == pattern.npos || pattern[end] != 'd') return std::nullopt;
  std::string digits = concat(number);
  const std::size_t width = parse_number<std::size_t>(pattern.substr(begin + 1, end - begin - 1)).value_or(0);
  if (width > 32) return std::nullopt;
  if (digits.size() < width) digits.insert(0, width - digits.size(), pattern[begin + 1] == '0' ? '0' : ' ');
  return pattern.substr(0, begin) + digits + pattern.substr(end + 1);
}

void set_samples(NeutralVolume& volume, Array<std::byte> samples) {
  volume.owned_samples = std::move(samples);
  volume.samples = volume.owned_samples;
  volume.mapping.reset();
  volume.samples_file.clear();
}

void leave_samples_in(NeutralVolume& volume, const ForeignFile& file, std::span<const std::byte> samples) {
  volume.samples = samples;
  volume.mapping = file.mapping();
  volume.samples_file = file.path();
  volume.samples_first_byte = static_cast<std::uint64_t>(samples.data() - file.bytes().data());
}

Affine axis_parallel(const Vec3& spacing, const Vec3& origin) {
  return {{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z}, origin};
}

void finish_volume(NeutralVolume& volume, const std::filesystem::path& path) {
  const Affine& map = volume.world_from_grid;
  if (!is_finite(map.x_axis) || !is_finite(map.y_axis) || !is_finite(map.z_axis) || !is_finite(map.origin))
    refuse_input(path, "header", "an origin, spacing or direction that is not finite", "finite numbers");
  const double volume_of_axes = map.x_axis.length() * map.y_axis.length() * map.z_axis.length();
  // sine of the smallest angle; written so that 0 is refused
  if (!(std::abs(map.determinant()) > 1e-9 * volume_of_axes))
    refuse_input(path, "header", "axes that lie in one plane, or a spacing of 0", "three independent axes");
  if (volume.type != ElementType::I64 && volume.type != ElementType::U64) return;
  std::optional<Array<std::byte>> doubles = volume.type == ElementType::I64 ? as_doubles<std::int64_t>(volume.samples)
                                                                            : as_doubles<std::uint64_t>(volume.samples);
  if (!doubles)
    refuse_input(path, "samples", "64-bit integers beyond 2^53", "integers that a 64-bit float holds exactly",
                 ErrorCode::unsupported);
  set_samples(volume, *std::move(doubles));
  volume.type = ElementType::F64;
  volume.notes.push_back("64-bit integers were converted to 64-bit floats without loss");
}

}  // namespace rhoray::preprocess
