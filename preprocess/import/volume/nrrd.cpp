#include <teem/nrrd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/library_text.h"
#include "formats/base/regular_file.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/label_names.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/volume/nrrd_header.h"
#include "preprocess/import/volume/nrrd_samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// Frees the description but not the samples, which belong to us.
struct NrrdNix {
  void operator()(Nrrd* nrrd) const { nrrdNix(nrrd); }
};
using OwnedNrrd = std::unique_ptr<Nrrd, NrrdNix>;

struct IoNix {
  void operator()(NrrdIoState* io) const { nrrdIoStateNix(io); }
};

struct Loaded {
  OwnedNrrd nrrd;
  std::unique_ptr<NrrdIoState, IoNix> io;
};

/// Refuses the file by what its header says and what Teem said about it.
[[noreturn]] void refuse_by_teem(const std::filesystem::path& path) {
  const std::unique_ptr<char, decltype(&std::free)> text(biffGetDone(NRRD), &std::free);
  const std::string_view reason = text ? text.get() : "";
  note_library_text(reason);
  refuse_nrrd(path, reason);
}

/// Refuses special files: Teem opens every file that a header names, and would wait for a pipe.
void require_regular_data_files(const std::filesystem::path& path) {
  const ForeignFile file(path);
  for (const std::string& name : files_named_by(nrrd_header(file.text())))
    if (is_there(path.parent_path() / name)) require_regular_file(path.parent_path() / name);
}

Loaded load_header(const std::filesystem::path& path) {
  require_regular_data_files(path);
  Loaded loaded{OwnedNrrd(nrrdNew()), std::unique_ptr<NrrdIoState, IoNix>(nrrdIoStateNew())};
  nrrdIoStateSet(loaded.io.get(), nrrdIoStateSkipData, 1);
  if (nrrdLoad(loaded.nrrd.get(), path.c_str(), loaded.io.get()) != 0) refuse_by_teem(path);
  return loaded;
}

/// Where Teem says that the samples are.
NrrdSamples samples_of(const std::filesystem::path& path, const NrrdIoState& io) {
  const ForeignFile file(path);
  const std::string_view header = nrrd_header(file.text());
  NrrdSamples samples{.header = path,
                      .parts = {},
                      .encoding = io.encoding->name,
                      .line_skip = io.lineSkip,
                      .byte_skip = io.byteSkip,
                      .is_big_endian = io.endian == airEndianBig};
  if (io.dataFNFormat == nullptr && io.dataFNArr->len == 0) {
    samples.parts.push_back({path, header.size()});
    return samples;
  }
  std::vector<std::string> names;
  if (io.dataFNFormat != nullptr) names = files_named_by(header);
  for (unsigned i = 0; i < io.dataFNArr->len; ++i) names.emplace_back(io.dataFN[i]);
  if (names.empty()) refuse_input(path, "key data file", in_quotes(io.dataFNFormat), "NAME%0Nd FIRST LAST STEP");
  for (const std::string& name : names) samples.parts.push_back({path.parent_path() / name});
  return samples;
}

/// Loads the samples into an array of our own: Teem fills memory that a Nrrd already has if its
/// size matches the file's header.
Array<std::byte> load_by_teem(const std::filesystem::path& path, const Nrrd& header, std::uint64_t bytes) {
  Array<std::byte> samples(bytes);
  const OwnedNrrd nrrd(nrrdNew());
  std::array<std::size_t, NRRD_DIM_MAX> sizes{};
  for (unsigned axis = 0; axis < header.dim; ++axis) sizes[axis] = header.axis[axis].size;
  if (nrrdWrap_nva(nrrd.get(), samples.data(), header.type, header.dim, sizes.data()) != 0) refuse_by_teem(path);
  if (nrrdLoad(nrrd.get(), path.c_str(), nullptr) != 0) refuse_by_teem(path);
  if (nrrd->data != samples.data())  // the file has changed since its header was read
    refuse_input(path, "samples", "another size than a moment ago", concat(bytes, " bytes"));
  return samples;
}

/// Leaves the samples in the file if one file holds them in the wanted form; false otherwise.
bool left_in_file(NeutralVolume& volume, const NrrdSamples& source, std::uint64_t bytes) {
  const bool is_raw = source.encoding == "raw" && source.line_skip == 0 && source.byte_skip >= -1;
  if (!is_raw || source.parts.size() != 1 || !is_native(volume.type, source.is_big_endian)) return false;
  const ForeignFile file(source.parts.front().file);
  leave_samples_in(volume, file, raw_samples(source, file, source.parts.front().begin, bytes, volume.notes));
  return true;
}

ElementType type_of(const std::filesystem::path& path, const Nrrd& nrrd) {
  static constexpr std::pair<int, ElementType> types[] = {
      {nrrdTypeChar, ElementType::I8},    {nrrdTypeUChar, ElementType::U8},   {nrrdTypeShort, ElementType::I16},
      {nrrdTypeUShort, ElementType::U16}, {nrrdTypeInt, ElementType::I32},    {nrrdTypeUInt, ElementType::U32},
      {nrrdTypeLLong, ElementType::I64},  {nrrdTypeULLong, ElementType::U64}, {nrrdTypeFloat, ElementType::F32},
      {nrrdTypeDouble, ElementType::F64}};
  const std::optional<ElementType> found = find_in(types, nrrd.type);
  if (!found)
    refuse_input(path, "key type", airEnumStr(nrrdType, nrrd.type), "integers or floating-point numbers",
                 ErrorCode::unsupported);
  return *found;
}

bool has_direction(const Nrrd& nrrd, unsigned axis) {
  return std::isfinite(nrrd.axis[axis].spaceDirection[0]);
}

bool is_in_space(const Nrrd& nrrd, unsigned axis) {
  const int kind = nrrd.axis[axis].kind;
  return kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace;
}

/// True if the fastest axis may hold red, green, blue, and perhaps alpha.
bool begins_with_colors(const Nrrd& nrrd) {
  const NrrdAxisInfo& axis = nrrd.axis[0];
  switch (axis.kind) {
    case nrrdKindUnknown:
    case nrrdKindList:
    case nrrdKindVector:
    case nrrdKind3Color:
    case nrrdKindRGBColor:
    case nrrdKind4Color:
    case nrrdKindRGBAColor:
    case nrrdKind3Vector:
    case nrrdKind4Vector:
      return (axis.size == 3 || axis.size == 4) && !has_direction(nrrd, 0);
    default:
      return false;
  }
}

/// The axis with the numbers of each sample, if there is one: the only one that is not in space, or
/// of four axes of unknown kinds the one without a direction, or the first if it may hold colours.
std::optional<unsigned> component_axis(const std::filesystem::path& path, const Nrrd& nrrd) {
  std::vector<unsigned> in_space, others, without_direction;
  for (unsigned axis = 0; axis < nrrd.dim; ++axis) {
    if (nrrd.axis[axis].size < 2) continue;
    (is_in_space(nrrd, axis) ? in_space : others).push_back(axis);
    if (is_in_space(nrrd, axis) && !has_direction(nrrd, axis)) without_direction.push_back(axis);
  }
  constexpr std::size_t most_numbers = 1024;
  for (const unsigned axis : others)
    if (others.size() > 1 || nrrd.axis[axis].kind == nrrdKindTime || nrrd.axis[axis].size > most_numbers)
      refuse_input(path, concat("axis ", axis),
                   concat(nrrd.axis[axis].size, " numbers for each sample (kind ",
                          airEnumStr(nrrdKind, nrrd.axis[axis].kind), ")"),
                   "one axis of numbers for each sample, and no times", ErrorCode::unsupported);
  if (others.size() == 1) return others.front();
  if (in_space.size() != 4) return std::nullopt;
  if (without_direction.size() == 1) return without_direction.front();
  return begins_with_colors(nrrd) ? std::optional(0U) : std::nullopt;
}

/// The three axes of the volume, fastest first. Any other axis must have one sample.
/// @param components  the axis with the numbers of each sample
std::array<unsigned, 3> volume_axes(const std::filesystem::path& path, const Nrrd& nrrd,
                                    std::optional<unsigned> components) {
  std::vector<unsigned> axes;
  for (unsigned axis = 0; axis < nrrd.dim; ++axis)
    if (axis != components && is_in_space(nrrd, axis)) axes.push_back(axis);
  for (std::size_t i = axes.size(); axes.size() > 3 && i-- > 0;)
    if (nrrd.axis[axes[i]].size == 1) axes.erase(axes.begin() + static_cast<std::ptrdiff_t>(i));
  if (axes.size() != 3)
    refuse_input(path, "key dimension", concat(axes.size(), " axes in space"), "3", ErrorCode::unsupported);
  return {axes[0], axes[1], axes[2]};
}

/// Distance between samples along an axis without a direction in space.
double spacing_of(const NrrdAxisInfo& axis) {
  if (std::isfinite(axis.spacing)) return axis.spacing;
  if (!std::isfinite(axis.min) || !std::isfinite(axis.max)) return 1;
  const auto samples = static_cast<double>(axis.size);
  return (axis.max - axis.min) / (axis.center == nrrdCenterNode ? samples - 1 : samples);
}

/// Position of the first sample on such an axis: `axis mins` is the cell's edge if samples
/// represent cells.
double first_position(const NrrdAxisInfo& axis) {
  if (!std::isfinite(axis.min)) return 0;
  const bool cells = axis.center == nrrdCenterCell ||
                     (axis.center == nrrdCenterUnknown && std::isfinite(axis.max) && !std::isfinite(axis.spacing));
  return axis.min + (cells ? 0.5 * spacing_of(axis) : 0.0);
}

Affine world_from_grid(const std::filesystem::path& path, const Nrrd& nrrd, const std::array<unsigned, 3>& axes) {
  std::array<Vec3, 3> columns;
  Vec3 origin(0, 0, 0);
  int directions = 0;
  for (int i = 0; i < 3; ++i) {
    const NrrdAxisInfo& axis = nrrd.axis[axes[static_cast<std::size_t>(i)]];
    Vec3& column = columns[static_cast<std::size_t>(i)];
    column = Vec3(0, 0, 0);
    if (nrrd.spaceDim > 0 && has_direction(nrrd, axes[static_cast<std::size_t>(i)])) {
      ++directions;
      for (int d = 0; d < 3; ++d) column[d] = axis.spaceDirection[d];
    } else {
      column[i] = spacing_of(axis);
      origin[i] = first_position(axis);
    }
  }
  if (directions > 0) {
    if (directions != 3 || nrrd.spaceDim != 3)
      refuse_input(path, "key space directions", concat(directions, " directions in ", nrrd.spaceDim, " dimensions"),
                   "3 directions in 3 dimensions");
    for (int d = 0; d < 3; ++d) origin[d] = std::isfinite(nrrd.spaceOrigin[d]) ? nrrd.spaceOrigin[d] : 0.0;
  }
  return {columns[0], columns[1], columns[2], origin};
}

/// The space of the file where it has one that is known here; world coordinates in "LAS" become
/// "RAS".
void set_space(const Nrrd& nrrd, NeutralVolume& volume) {
  Affine& map = volume.world_from_grid;
  switch (nrrd.space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime:
      volume.space = formats::Space::ras;
      return;
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime:
      volume.space = formats::Space::lps;
      return;
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime:
      volume.space = formats::Space::ras;
      for (Vec3* vector : {&map.x_axis, &map.y_axis, &map.z_axis, &map.origin}) vector->x = -vector->x;
      return;
    default:
      return;
  }
}

/// The unit of length, if all three axes agree on one.
std::string length_unit(const Nrrd& nrrd, const std::array<unsigned, 3>& axes) {
  std::array<std::string, 3> units;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool in_space = nrrd.spaceDim == 3 && has_direction(nrrd, axes[i]);
    const char* unit = in_space ? nrrd.spaceUnits[i] : nrrd.axis[axes[i]].units;
    units[i] = unit == nullptr ? "" : unit;
  }
  return units[0] == units[1] && units[1] == units[2] ? units[0] : "";
}

/// The unit of the samples, without the quotes that some files have and Teem keeps.
std::string sample_unit(const Nrrd& nrrd) {
  std::string unit = nrrd.sampleUnits == nullptr ? "" : nrrd.sampleUnits;
  if (unit.size() >= 2 && unit.front() == '"' && unit.back() == '"') unit = unit.substr(1, unit.size() - 2);
  return unit;
}

/// A segment, as keys such as `Segment0_Name:=liver` describe it; 3D Slicer writes them.
struct Segment {
  std::string name;
  std::int64_t label = 0;
  bool is_in_first_layer = true;
};

using FreedText = std::unique_ptr<char, decltype(&std::free)>;

std::string_view without_spaces(std::string_view text) {
  constexpr std::string_view spaces = " \t\r";
  const std::size_t begin = text.find_first_not_of(spaces);
  return begin == text.npos ? std::string_view() : text.substr(begin, text.find_last_not_of(spaces) - begin + 1);
}

/// Includes a key of the file if it describes a segment. A label that is no number names no label.
void include_key(std::string_view key, std::string_view value, std::map<std::uint32_t, Segment>& segments) {
  constexpr std::string_view beginning = "Segment";
  const std::size_t bar = key.find('_');
  if (!key.starts_with(beginning) || bar == key.npos) return;
  const auto index = parse_number<std::uint32_t>(key.substr(beginning.size(), bar - beginning.size()));
  if (!index) return;
  Segment& segment = segments.try_emplace(*index, Segment{.name = {}, .label = std::int64_t{*index} + 1}).first->second;
  const std::string_view what = key.substr(bar + 1);
  if (what == "Name") segment.name = value;
  if (what == "Layer") segment.is_in_first_layer = parse_number<int>(value) == 0;
  if (what == "LabelValue")
    segment.label = parse_number<std::int64_t>(value).value_or(std::numeric_limits<std::int64_t>::max());
}

/// Names of segments. Those of other layers than the first have no samples here.
formats::LabelNames segment_names(const Nrrd& nrrd, std::vector<std::string>& notes) {
  std::map<std::uint32_t, Segment> segments;
  for (unsigned i = 0; i < nrrdKeyValueSize(&nrrd); ++i) {
    char *key = nullptr, *value = nullptr;
    nrrdKeyValueIndex(&nrrd, &key, &value, i);
    const FreedText freed_key(key, &std::free), freed_value(value, &std::free);
    if (key != nullptr && value != nullptr) include_key(without_spaces(key), without_spaces(value), segments);
  }
  GivenNames names;
  std::size_t elsewhere = 0;
  for (const auto& [index, segment] : segments)
    if (segment.is_in_first_layer)
      names.emplace_back(segment.label, segment.name);
    else
      ++elsewhere;
  if (elsewhere != 0)
    notes.push_back(concat(count_text(elsewhere, "segment", "segments"), " of other layers left out; layer 0 is read"));
  return label_names_from(names, notes);
}

void check_colors(const std::filesystem::path& path, const Nrrd& nrrd) {
  if (!begins_with_colors(nrrd))
    refuse_input(path, "axis 0",
                 concat(nrrd.axis[0].size, " samples of kind ", airEnumStr(nrrdKind, nrrd.axis[0].kind)),
                 "3 or 4 of kind RGB-color, RGBA-color or vector: colours", ErrorCode::unsupported);
  if (nrrd.type != nrrdTypeUChar)
    refuse_input(path, "key type", airEnumStr(nrrdType, nrrd.type), "uchar: colours of 8 bits", ErrorCode::unsupported);
}

/// Takes the chosen scalar from all numbers of each sample.
/// @param axis  the axis with these numbers
void take_component(NeutralVolume& volume, Samples samples, int component, const Nrrd& nrrd, unsigned axis) {
  PlanarShape shape;
  for (unsigned i = 0; i < nrrd.dim; ++i) {
    if (i < axis) shape.inner *= nrrd.axis[i].size;
    if (i > axis) shape.outer *= nrrd.axis[i].size;
  }
  interleave(samples, shape);
  const int kind = nrrd.axis[axis].kind;
  if (kind == nrrdKind3DMaskedSymMatrix) pick(samples, {1, 4, 6, 2, 5, 3});
  if (kind == nrrdKind3DSymMatrix) pick(samples, from_upper_rows);
  if (kind == nrrdKind3DMaskedMatrix) pick(samples, {1, 2, 3, 4, 5, 6, 7, 8, 9});
  take_scalar(volume, std::move(samples), component);
}

/// Numbers for each sample, without the mask of masked tensors.
int component_count(const Nrrd& nrrd, std::optional<unsigned> axis) {
  if (!axis) return 1;
  const int kind = nrrd.axis[*axis].kind;
  const bool is_masked = kind == nrrdKind3DMaskedSymMatrix || kind == nrrdKind3DMaskedMatrix;
  return static_cast<int>(nrrd.axis[*axis].size) - (is_masked ? 1 : 0);
}

/// @param colors  true: read only samples with 3 or 4 components of 8 bits
NeutralVolume read_samples(const std::filesystem::path& path, const std::string& field, bool colors) {
  check_nrrd_magic(path);
  // Read the header alone, so that nothing is allocated for sizes that are refused.
  const auto [header, io] = load_header(path);
  if (colors) check_colors(path, *header);
  const std::optional<unsigned> numbers_axis = colors ? std::optional(0U) : component_axis(path, *header);
  const std::array<unsigned, 3> axes = volume_axes(path, *header, numbers_axis);
  const auto size = [&, &nrrd = *header](std::size_t i) { return static_cast<std::int64_t>(nrrd.axis[axes[i]].size); };
  NeutralVolume volume;
  volume.sample_count = {size(0), size(1), size(2)};
  if (colors) volume.component_count = static_cast<int>(header->axis[0].size);
  volume.type = type_of(path, *header);
  volume.world_from_grid = world_from_grid(path, *header, axes);
  volume.length_unit = length_unit(*header, axes);
  set_space(*header, volume);
  volume.field_unit = sample_unit(*header);
  const std::vector<VectorArray> arrays{{stem_of(path), colors ? 1 : component_count(*header, numbers_axis)}};
  const ScalarChoice choice = choose_scalar(path, arrays, field);
  set_names(volume, arrays, choice, field);
  const int numbers = numbers_axis ? static_cast<int>(header->axis[*numbers_axis].size) : 1;
  if (!colors && numbers == 1) volume.label_names = segment_names(*header, volume.notes);
  const std::uint64_t bytes = checked_array_bytes(path, volume.sample_count, {volume.type, numbers});
  const NrrdSamples source = samples_of(path, *io);
  check_data_size(source, bytes, bytes / formats::element_bytes(volume.type));
  const auto load = [&, &header = header] {
    return is_read_here(source) ? load_samples(source, volume.type, bytes, volume.notes)
                                : load_by_teem(path, *header, bytes);
  };
  if (arrays.front().component_count > 1)
    take_component(volume, {volume.type, numbers, load()}, choice.component, *header, *numbers_axis);
  else if (!left_in_file(volume, source, bytes))
    set_samples(volume, load());
  finish_volume(volume, path);
  return volume;
}

}  // namespace

NeutralVolume read_nrrd(const std::filesystem::path& path, const std::string& field) {
  return read_samples(path, field, false);
}

NeutralVolume read_nrrd_colors(const std::filesystem::path& path, const std::string& field) {
  return read_samples(path, field, true);
}

}  // namespace rhoray::preprocess
