// NumPy's files of one array (.npy) and its archives of several (.npz). The last axis of an array
// is x, as in a[z, y, x]. Source: NumPy, numpy/lib/format.py.

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <tuple>

#include "preprocess/import/reading/array_choice.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/reading/zip_archive.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

/// The header of a NumPy array.
struct Header {
  std::string descr;  ///< "<f4"; empty for a structured type
  bool fortran_order = false;
  std::vector<std::int64_t> shape;
  std::uint64_t byte_count = 0;  ///< of the header itself
};

/// Fills these bytes with the next ones.
using Read = std::function<void(std::span<std::byte>)>;

/// The text behind a key of the header, which is a dictionary of Python; refuses a missing key.
std::string_view value_of(std::string_view dictionary, std::string_view key, const fs::path& path) {
  constexpr std::string_view spaces = " \t\n";
  const std::size_t at = dictionary.find(concat("'", key, "'"));
  if (at == dictionary.npos) refuse_input(path, "header", concat("no key '", key, "'"), "descr, fortran_order, shape");
  const std::size_t colon = dictionary.find_first_not_of(spaces, at + key.size() + 2);
  if (colon == dictionary.npos || dictionary[colon] != ':') refuse_input(path, "header", "no colon behind a key", ":");
  return dictionary.substr(std::min(dictionary.find_first_not_of(spaces, colon + 1), dictionary.size()));
}

std::vector<std::int64_t> shape_in(std::string_view text, const fs::path& path) {
  const auto refuse = [&] { refuse_input(path, "key shape", in_quotes(text), "sizes, such as (5, 4, 3)"); };
  const std::size_t end = text.find(')');
  if (!text.starts_with('(') || end == text.npos) refuse();
  std::vector<std::int64_t> shape;
  for (std::size_t at = 1; at < end;) {
    const std::size_t comma = std::min(text.find(',', at), end);
    std::string_view word = text.substr(at, comma - at);
    word.remove_prefix(std::min(word.find_first_not_of(' '), word.size()));
    word = word.substr(0, word.find_last_not_of(' ') + 1);
    const std::optional<std::int64_t> size = parse_number<std::int64_t>(word);
    if (!size && (!word.empty() || comma != end)) refuse();
    if (size) shape.push_back(*size);
    at = comma + 1;
  }
  return shape;
}

Header read_header(const Read& read, const fs::path& path) {
  std::array<unsigned char, 12> start{};
  read(std::as_writable_bytes(std::span(start).first(10)));
  if (std::memcmp(start.data(), "\x93NUMPY", 6) != 0) refuse_input(path, "byte 0", "another beginning", "\\x93NUMPY");
  const unsigned version = start[6];
  if (version < 1 || version > 3)
    refuse_input(path, "byte 6", concat("version ", version), "1 to 3", ErrorCode::unsupported);
  if (version > 1) read(std::as_writable_bytes(std::span(start).subspan(10)));
  std::size_t length = start[8] + 256U * start[9];
  if (version > 1) length += (start[10] + 256U * start[11]) * std::size_t{65536};
  constexpr std::size_t longest = 65535;
  if (length > longest) refuse_input(path, "header", concat(length, " bytes"), concat("at most ", longest));
  std::string dictionary(length, '\0');
  read(std::as_writable_bytes(std::span(dictionary)));

  Header header;
  header.byte_count = (version > 1 ? 12 : 10) + length;
  const std::string_view descr = value_of(dictionary, "descr", path);
  if (descr.starts_with('\'')) header.descr = descr.substr(1, descr.find('\'', 1) - 1);
  header.fortran_order = value_of(dictionary, "fortran_order", path).starts_with("True");
  header.shape = shape_in(value_of(dictionary, "shape", path), path);
  return header;
}

ElementType type_of(const Header& header, const fs::path& path) {
  static constexpr std::pair<std::string_view, ElementType> types[] = {
      {"b1", ElementType::U8},  {"u1", ElementType::U8},  {"i1", ElementType::I8},  {"u2", ElementType::U16},
      {"i2", ElementType::I16}, {"u4", ElementType::U32}, {"i4", ElementType::I32}, {"u8", ElementType::U64},
      {"i8", ElementType::I64}, {"f4", ElementType::F32}, {"f8", ElementType::F64}};
  const std::string_view descr = header.descr;
  const std::optional<ElementType> found = find_in(types, descr.substr(std::min<std::size_t>(1, descr.size())));
  if (!found)
    throw Error(ErrorCode::unsupported,
                concat(path.string(), ", key descr: found ", descr.empty() ? "a structured type" : in_quotes(descr),
                       "; expected integers of 8 to 64 bits, or floating-point numbers of 32 or 64"),
                "convert it first, for example numpy.save(name, array.astype('float32'))");
  return *found;
}

/// Takes an array in Fortran order, a[z, y, x] with z fastest: makes x fastest.
template <class T>
void put_x_first(std::span<const std::byte> from, std::span<std::byte> to, const Index3& n) {
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i)
        std::memcpy(to.data() + static_cast<std::size_t>((k * n.y + j) * n.x + i) * sizeof(T),
                    from.data() + static_cast<std::size_t>((i * n.y + j) * n.z + k) * sizeof(T), sizeof(T));
}

std::size_t axis_count(bool colors) {
  return colors ? 4 : 3;
}

constexpr const char* expected_axes = "3 axes: z, y, x, or a fourth, last, of 2 to 9 numbers for each sample";

/// The volume without its samples, and their number of bytes.
/// @param colors  true: the last axis has the 3 or 4 components of a colour
/// @param held    bytes that follow the header
std::pair<NeutralVolume, std::uint64_t> describe(const std::string& name, const Header& header, bool colors,
                                                 std::uint64_t held, const fs::path& path) {
  const std::optional<int> count = component_count_of(header.shape);
  if (colors || !count)
    check_axes(path, {name, header.shape}, axis_count(colors), colors ? "4 axes: z, y, x and colour" : expected_axes);
  NeutralVolume volume;
  volume.type = type_of(header, path);
  volume.sample_count = {header.shape[2], header.shape[1], header.shape[0]};
  volume.component_count = count.value_or(0);
  if (colors) {
    if (volume.type != ElementType::U8 || (volume.component_count != 3 && volume.component_count != 4))
      refuse_input(path, "header",
                   concat(header.shape[3], " components of ", formats::element_name(volume.type), " for each sample"),
                   "3 or 4 of U8: colours", ErrorCode::unsupported);
    if (header.fortran_order)
      refuse_input(path, "key fortran_order", "True", "False for colours", ErrorCode::unsupported);
  }
  const std::uint64_t bytes =
      colors ? checked_color_bytes(path, volume.sample_count, volume.component_count)
             : checked_array_bytes(path, volume.sample_count, {volume.type, volume.component_count});
  if (bytes > held) refuse_input(path, "key shape", concat(held, " bytes of numbers"), concat(bytes));
  if (bytes < held) volume.notes.push_back(concat(held - bytes, " bytes after the array were left out"));
  return {std::move(volume), bytes};
}

bool is_big_endian(const Header& header) {
  return header.descr.starts_with('>');
}

/// Reads the numbers and brings them to our order.
Samples read_samples(const NeutralVolume& volume, std::uint64_t bytes, const Header& header, const Read& read) {
  Samples samples{volume.type, volume.component_count, Array<std::byte>(bytes)};
  read(samples.values);
  make_native(samples.values, formats::element_bytes(volume.type), is_big_endian(header));
  if (!header.fortran_order) return samples;
  const auto components = static_cast<std::size_t>(volume.component_count);
  Array<std::byte> turned(bytes);
  formats::with_element_type(volume.type, [&]<class T>(T) {
    for (std::size_t c = 0; c < components; ++c)
      put_x_first<T>(std::span(samples.values).subspan(c * bytes / components, bytes / components),
                     std::span(turned).subspan(c * bytes / components, bytes / components), volume.sample_count);
  });
  samples.values = std::move(turned);
  interleave(samples, {.inner = static_cast<std::size_t>(rhoray::volume(volume.sample_count))});
  return samples;
}

/// @param colors  true: keep all numbers of each sample
void take(NeutralVolume& volume, Samples samples, int component, bool colors) {
  if (colors) return set_samples(volume, std::move(samples.values));
  volume.component_count = 1;
  take_scalar(volume, std::move(samples), component);
}

NeutralVolume read_array(const fs::path& path, const std::string& field, bool colors) {
  const ForeignFile file(path);
  std::span<const std::byte> rest = file.bytes();
  const Read read = [&](std::span<std::byte> to) {
    if (to.size() > rest.size())
      refuse_input(path, concat("byte ", file.bytes().size()), "the end of the file",
                   concat(to.size() - rest.size(), " bytes more"));
    std::copy_n(rest.begin(), to.size(), to.begin());
    rest = rest.subspan(to.size());
  };
  const Header header = read_header(read, path);
  auto [volume, bytes] = describe(stem_of(path), header, colors, rest.size(), path);
  const std::vector<VectorArray> arrays{{stem_of(path), colors ? 1 : volume.component_count}};
  const ScalarChoice choice = choose_scalar(path, arrays, field);
  set_names(volume, arrays, choice, field);
  if (arrays.front().component_count == 1 && !header.fortran_order && is_native(volume.type, is_big_endian(header)))
    leave_samples_in(volume, file, rest.first(bytes));
  else
    take(volume, read_samples(volume, bytes, header, read), choice.component, colors);
  finish_volume(volume, path);
  return std::move(volume);
}

constexpr std::string_view member_ending = ".npy";

std::vector<NamedShape> arrays_in(const fs::path& path) {
  std::vector<NamedShape> arrays;
  visit_zip(path, [&](const ZipEntry& entry) {
    if (!entry.name.ends_with(member_ending)) return;
    arrays.push_back(
        {entry.name.substr(0, entry.name.size() - member_ending.size()), read_header(entry.read, path).shape});
  });
  return arrays;
}

/// The array of colours that `field` names, or the first.
VolumeChoice choose_colors(const fs::path& path, const std::vector<NamedShape>& arrays, const std::string& field) {
  VolumeChoice choice{.array = choose_array(path, arrays, field, axis_count(true)), .volumes = {}, .scalar = {}};
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (i == choice.array) choice.scalar.array = choice.volumes.size();
    if (i == choice.array || arrays[i].shape.size() == axis_count(true)) choice.volumes.push_back({arrays[i].name, 1});
  }
  return choice;
}

NeutralVolume read_archive(const fs::path& path, const std::string& field, bool colors) {
  const std::vector<NamedShape> arrays = arrays_in(path);
  const VolumeChoice choice =
      colors ? choose_colors(path, arrays, field) : choose_volume(path, arrays, field, expected_axes);
  const std::string& name = arrays[choice.array].name;
  NeutralVolume volume;
  visit_zip(path, [&](const ZipEntry& entry) {
    if (entry.name != concat(name, member_ending) || !volume.samples.empty()) return;
    const Header header = read_header(entry.read, path);
    std::uint64_t bytes = 0;
    std::tie(volume, bytes) = describe(name, header, colors, entry.size - header.byte_count, path);
    take(volume, read_samples(volume, bytes, header, entry.read), choice.scalar.component, colors);
    entry.finish();
  });
  set_names(volume, choice.volumes, choice.scalar, field);
  finish_volume(volume, path);
  return volume;
}

}  // namespace

NeutralVolume read_npy(const fs::path& path, const std::string& field) {
  return read_array(path, field, false);
}

NeutralVolume read_npy_colors(const fs::path& path, const std::string& field) {
  return read_array(path, field, true);
}

NeutralVolume read_npz(const fs::path& path, const std::string& field) {
  return read_archive(path, field, false);
}

NeutralVolume read_npz_colors(const fs::path& path, const std::string& field) {
  return read_archive(path, field, true);
}

}  // namespace rhoray::preprocess
