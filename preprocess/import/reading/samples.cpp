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

void check_packed_size(const std::filesystem::path& path, std::uint64_t wanted_bytes, std::uint64_t file_bytes) {
  constexpr std::uint64_t tightest = 1040;  // zlib compresses to about 1/1032 at best
  if (wanted_bytes / tightest > file_bytes)
    refuse_input(path, "header", concat("sizes that need ", wanted_bytes, " bytes, in ", file_bytes, " packed bytes"),
                 "sizes that the packed bytes can hold");
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

namespace {

/// One array or a part of it: `component` counts from 0, or is `magnitude`.
struct Choice {
  static constexpr int magnitude = -1;
  std::size_t array = 0;
  int component = 0;
};

std::string names_of(const std::vector<GridArray>& arrays) {
  std::string names;
  for (const GridArray& array : arrays) {
    names += names.empty() ? array.name : ", " + array.name;
    if (array.component_count > 1) names += concat(" (", array.component_count, " components)");
  }
  return names;
}

std::string ways_to_name(const GridArray& array) {
  return concat("use --field with one component, ", array.name, ".0 to ", array.name, ".", array.component_count - 1,
                array.component_count == 2   ? " or .x .y"
                : array.component_count == 3 ? " or .x .y .z"
                                             : "",
                ", or the length, ", array.name, ".mag");
}

std::optional<int> component_named(std::string_view name, int count) {
  if (name == "mag") return Choice::magnitude;
  if (name == "x" || name == "y" || name == "z") {
    const int component = name[0] - 'x';
    return count <= 3 && component < count ? std::optional(component) : std::nullopt;
  }
  const std::optional<int> component = parse_number<int>(name);
  return component && *component >= 0 && *component < count ? component : std::nullopt;
}

Choice choose(const std::filesystem::path& path, const std::vector<GridArray>& arrays, const std::string& field) {
  if (arrays.empty()) refuse_input(path, "header", "no values at points or in cells", "at least one array");
  if (field.empty()) {
    for (std::size_t i = 0; i < arrays.size(); ++i)
      if (arrays[i].component_count == 1) return {.array = i};
    throw VectorsOnly({ErrorCode::unsupported,
                       concat(path.string(), ": found only arrays with several components: ", names_of(arrays),
                              "; expected one with a single component"),
                       ways_to_name(arrays.front())},
                      arrays.front().name);
  }
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (field != arrays[i].name) continue;
    if (arrays[i].component_count == 1) return {.array = i};
    throw Error(
        ErrorCode::usage,
        concat(path.string(), ", field '", field, "': found ", arrays[i].component_count, " components; expected 1"),
        ways_to_name(arrays[i]));
  }
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (!field.starts_with(arrays[i].name + ".")) continue;
    const std::string_view part = std::string_view(field).substr(arrays[i].name.size() + 1);
    if (const std::optional<int> component = component_named(part, arrays[i].component_count))
      return {.array = i, .component = *component};
  }
  throw Error(ErrorCode::usage,
              concat(path.string(), ": found no field '", field, "'; expected one of: ", names_of(arrays)));
}

template <class T>
Array<std::byte> component_of(const GridArray& array, int component) {
  const auto stride = static_cast<std::size_t>(array.component_count) * sizeof(T);
  Array<std::byte> result(array.values.size() / static_cast<std::size_t>(array.component_count));
  const std::byte* from = array.values.data() + static_cast<std::size_t>(component) * sizeof(T);
  for (std::size_t to = 0; to < result.size(); to += sizeof(T), from += stride)
    std::memcpy(result.data() + to, from, sizeof(T));
  return result;
}

template <class T, class Result>
Array<std::byte> magnitude_of(const GridArray& array) {
  const auto components = static_cast<std::size_t>(array.component_count);
  const std::size_t count = array.values.size() / sizeof(T) / components;
  Array<std::byte> result(count * sizeof(Result));
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0;
    for (std::size_t c = 0; c < components; ++c) {
      T value;
      std::memcpy(&value, array.values.data() + (i * components + c) * sizeof(T), sizeof value);
      sum += static_cast<double>(value) * static_cast<double>(value);
    }
    const auto length = static_cast<Result>(std::sqrt(sum));
    std::memcpy(result.data() + i * sizeof(Result), &length, sizeof length);
  }
  return result;
}

void set_chosen(NeutralVolume& volume, GridArray& array, int component) {
  volume.type = array.type;
  if (component == Choice::magnitude) {
    const bool wide =
        formats::element_bytes(array.type) == 8 || array.type == ElementType::I32 || array.type == ElementType::U32;
    volume.type = wide ? ElementType::F64 : ElementType::F32;
    set_samples(volume, formats::with_element_type(array.type, [&]<class T>(T) {
                  return wide ? magnitude_of<T, double>(array) : magnitude_of<T, float>(array);
                }));
  } else if (array.component_count > 1) {
    set_samples(volume,
                formats::with_element_type(array.type, [&]<class T>(T) { return component_of<T>(array, component); }));
  } else {
    set_samples(volume, std::move(array.values));
  }
}

/// The array, with its values.
GridArray& loaded(GridArray& array) {
  if (array.load) array.values = array.load();
  return array;
}

/// Samples at cell centres: one fewer on each axis with more than one point.
PointGrid cell_middles(const PointGrid& grid) {
  PointGrid middles = grid;
  Vec3 first(0, 0, 0);
  for (int axis = 0; axis < 3; ++axis) {
    if (grid.point_count[axis] < 2) continue;
    --middles.point_count[axis];
    std::vector<double>& table = middles.axes[static_cast<std::size_t>(axis)];
    if (table.empty()) {
      first[axis] = 0.5;
      continue;
    }
    for (std::size_t i = 0; i + 1 < table.size(); ++i) table[i] = table[i] + (table[i + 1] - table[i]) / 2;
    table.pop_back();
  }
  middles.world_from_grid.origin = grid.world_from_grid.point(first);
  return middles;
}

/// True when position i equals first + i * step, within the given precision.
bool is_uniform(const std::vector<double>& positions, double relative_precision) {
  const double first = positions.front(), last = positions.back();
  const double step = (last - first) / static_cast<double>(positions.size() - 1);
  const double tolerance = 2 * relative_precision * std::max(std::abs(first), std::abs(last));
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (!(std::abs(positions[i] - (first + static_cast<double>(i) * step)) <= tolerance)) return false;
  return true;
}

void check_positions(const std::filesystem::path& path, char axis, const std::vector<double>& positions) {
  const bool rises = positions.front() < positions.back();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const bool goes_on = i == 0 || (rises ? positions[i - 1] < positions[i] : positions[i] < positions[i - 1]);
    if (goes_on && std::isfinite(positions[i])) continue;
    refuse_input(path, concat(axis, " coordinate ", i),
                 i == 0 ? concat(positions[i]) : concat(positions[i], " after ", positions[i - 1]),
                 "finite positions that rise, or fall, from point to point");
  }
}

}  // namespace

PointGrid rectilinear_grid(const std::filesystem::path& path, const std::array<std::vector<double>, 3>& positions,
                           double relative_precision) {
  PointGrid grid;
  Vec3 step(1, 1, 1), origin(0, 0, 0);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::vector<double>& places = positions[a];
    const auto axis = static_cast<int>(a);
    if (places.empty()) refuse_input(path, concat("xyz"[a], " coordinates"), "none", "at least one");
    grid.point_count[axis] = static_cast<std::int64_t>(places.size());
    if (places.size() == 1) {
      origin[axis] = places.front();
      continue;
    }
    check_positions(path, "xyz"[a], places);
    if (is_uniform(places, relative_precision)) {
      origin[axis] = places.front();
      step[axis] = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
      continue;
    }
    // a table must increase: its axis points the other way
    if (places.back() < places.front()) step[axis] = -1;
    for (const double place : places) grid.axes[a].push_back(step[axis] * place);
  }
  grid.world_from_grid = axis_parallel(step, origin);
  return grid;
}

NeutralVolume volume_of_field(const std::filesystem::path& path, const PointGrid& points, std::vector<GridArray> arrays,
                              const std::string& field) {
  const Choice choice = choose(path, arrays, field);
  GridArray& array = loaded(arrays[choice.array]);
  const PointGrid grid = array.in_cells ? cell_middles(points) : points;
  const std::uint64_t bytes = checked_volume_bytes(path, grid.point_count, array.type);
  const auto components = static_cast<std::uint64_t>(array.component_count);
  if (array.values.size() / components != bytes || array.values.size() % components != 0)
    refuse_input(path, concat("array '", array.name, "'"), concat(array.values.size(), " bytes"),
                 concat(components, " x ", bytes));
  NeutralVolume volume;
  volume.sample_count = grid.point_count;
  volume.world_from_grid = grid.world_from_grid;
  volume.axes = grid.axes;
  for (std::size_t i = 0; i < arrays.size(); ++i)
    if (arrays[i].component_count > 1)
      volume.vectors.push_back({arrays[i].name, arrays[i].component_count});
    else if (i != choice.array)
      volume.other_fields.push_back(arrays[i].name);
  volume.field_name = field.empty() ? array.name : field;
  if (array.in_cells) volume.notes.push_back("cell data: each value was placed at its cell's centre");
  set_chosen(volume, array, choice.component);
  finish_volume(volume, path);
  return volume;
}

namespace {

bool holds_colors(const GridArray& array) {
  return array.type == ElementType::U8 && (array.component_count == 3 || array.component_count == 4);
}

GridArray& choose_colors(const std::filesystem::path& path, std::vector<GridArray>& arrays, const std::string& field) {
  for (GridArray& array : arrays) {
    if (field.empty() ? !holds_colors(array) || array.in_cells : array.name != field) continue;
    const std::string place = concat("array '", array.name, "'");
    if (!holds_colors(array))
      refuse_input(path, place, concat(array.component_count, " components of ", formats::element_name(array.type)),
                   "3 or 4 of U8: colours", ErrorCode::unsupported);
    if (array.in_cells) refuse_input(path, place, "colours in cells", "colours at points", ErrorCode::unsupported);
    return array;
  }
  throw Error(field.empty() ? ErrorCode::unsupported : ErrorCode::usage,
              concat(path.string(), ": found no ", field.empty() ? "colours" : concat("field '", field, "'"),
                     "; expected an array of 3 or 4 components of U8 at points, of: ", names_of(arrays)));
}

}  // namespace

NeutralVolume colors_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field) {
  GridArray& array = loaded(choose_colors(path, arrays, field));
  NeutralVolume volume;
  volume.component_count = array.component_count;
  volume.sample_count = grid.point_count;
  volume.world_from_grid = grid.world_from_grid;
  volume.field_name = array.name;
  const std::uint64_t bytes = checked_color_bytes(path, grid.point_count, array.component_count);
  if (array.values.size() != bytes)
    refuse_input(path, concat("array '", array.name, "'"), concat(array.values.size(), " bytes"), concat(bytes));
  set_samples(volume, std::move(array.values));
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
