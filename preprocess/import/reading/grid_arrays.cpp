#include "preprocess/import/reading/grid_arrays.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/word_list.h"
#include "preprocess/components.h"
#include "preprocess/import/reading/hidden_samples.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

using formats::ElementType;

namespace {

std::string names_of(const std::vector<VectorArray>& arrays) {
  std::string names;
  for (const VectorArray& array : arrays) {
    names += names.empty() ? array.name : ", " + array.name;
    if (array.component_count > 1) names += concat(" (", array.component_count, " components)");
  }
  return names;
}

std::vector<VectorArray> shapes_of(const std::vector<GridArray>& arrays) {
  std::vector<VectorArray> shapes;
  for (const GridArray& array : arrays) shapes.push_back({array.name, array.component_count});
  return shapes;
}

[[noreturn]] void refuse_field(const std::filesystem::path& path, const std::vector<VectorArray>& arrays,
                               const std::string& field) {
  std::vector<std::string> names, texts;
  for (const VectorArray& array : arrays) {
    if (array.name == field)
      throw Error(ErrorCode::usage,
                  concat(path.string(), ", field '", field, "': found ", array.component_count,
                         " components; expected one scalar of: ", scalars_text(array.name, array.component_count)),
                  concat("for its magnitude use --field ", field, ".mag"));
    for (std::string& name : scalars_of(array.name, array.component_count)) names.push_back(std::move(name));
    texts.push_back(scalars_text(array.name, array.component_count));
  }
  throw Error(ErrorCode::usage,
              concat(path.string(), ": found no field '", field, "'; expected one of: ", joined(texts)),
              did_you_mean(field, names));
}

template <class T>
Array<std::byte> component_of(const Samples& samples, int component) {
  const auto stride = static_cast<std::size_t>(samples.component_count) * sizeof(T);
  Array<std::byte> result(samples.values.size() / static_cast<std::size_t>(samples.component_count));
  const std::byte* from = samples.values.data() + static_cast<std::size_t>(component) * sizeof(T);
  for (std::size_t to = 0; to < result.size(); to += sizeof(T), from += stride)
    std::memcpy(result.data() + to, from, sizeof(T));
  return result;
}

template <class Result>
Array<std::byte> magnitudes_of(const Samples& samples) {
  std::vector<double> numbers(static_cast<std::size_t>(samples.component_count));
  const std::size_t bytes = numbers.size() * formats::element_bytes(samples.type);
  const std::size_t count = samples.values.size() / bytes;
  Array<std::byte> result(count * sizeof(Result));
  for (std::size_t i = 0; i < count; ++i) {
    copy_as_doubles(samples.type, std::span(samples.values).subspan(i * bytes, bytes), numbers.data());
    const auto value = static_cast<Result>(magnitude_of(numbers));
    std::memcpy(result.data() + i * sizeof(Result), &value, sizeof value);
  }
  return result;
}

}  // namespace

ScalarChoice choose_scalar(const std::filesystem::path& path, const std::vector<VectorArray>& arrays,
                           const std::string& field) {
  if (arrays.empty()) refuse_input(path, "header", "no values at points or in cells", "at least one array");
  for (std::size_t i = 0; i < arrays.size(); ++i)
    if (field.empty() ? arrays[i].component_count == 1 : arrays[i].component_count == 1 && arrays[i].name == field)
      return {.array = i};
  if (field.empty()) return {.array = 0, .component = magnitude_component};
  for (std::size_t i = 0; i < arrays.size(); ++i)
    if (const auto component = component_in(field, arrays[i].name, arrays[i].component_count))
      return {.array = i, .component = *component};
  refuse_field(path, arrays, field);
}

void set_names(NeutralVolume& volume, const std::vector<VectorArray>& arrays, const ScalarChoice& choice,
               const std::string& field) {
  for (std::size_t i = 0; i < arrays.size(); ++i)
    if (arrays[i].component_count > 1)
      volume.vectors.push_back(arrays[i]);
    else if (i != choice.array)
      volume.other_fields.push_back(arrays[i].name);
  const auto& [name, count] = arrays[choice.array];
  volume.field_name = scalar_name(name, count, choice.component);
  if (!field.empty()) return;
  if (std::string note = note_of_choice(arrays, choice.array, choice.component); !note.empty())
    volume.notes.push_back(std::move(note));
}

std::uint64_t checked_array_bytes(const std::filesystem::path& path, const Index3& n, const SampleKind& kind) {
  const auto components = static_cast<std::uint64_t>(kind.component_count);
  const std::optional<std::uint64_t> bytes = checked_product({checked_volume_bytes(path, n, kind.type), components});
  if (!bytes)
    refuse_input(path, "header", concat(n.x, " x ", n.y, " x ", n.z, " samples of ", components, " numbers"),
                 "a size that fits in memory");
  return *bytes;
}

void take_scalar(NeutralVolume& volume, Samples samples, int component) {
  volume.type = samples.type;
  if (component == magnitude_component) {
    const bool is_wide = formats::element_bytes(samples.type) == 8 || samples.type == ElementType::I32 ||
                         samples.type == ElementType::U32;
    volume.type = is_wide ? ElementType::F64 : ElementType::F32;
    set_samples(volume, is_wide ? magnitudes_of<double>(samples) : magnitudes_of<float>(samples));
  } else if (samples.component_count > 1) {
    set_samples(volume, formats::with_element_type(samples.type,
                                                   [&]<class T>(T) { return component_of<T>(samples, component); }));
  } else {
    set_samples(volume, std::move(samples.values));
  }
}

void interleave(Samples& samples, const PlanarShape& shape) {
  const auto components = static_cast<std::size_t>(samples.component_count);
  const std::size_t bytes = formats::element_bytes(samples.type);
  if (components == 1 || shape.inner == 1) return;
  Array<std::byte> result(samples.values.size());
  const std::byte* from = samples.values.data();
  for (std::size_t block = 0; block < shape.outer; ++block)
    for (std::size_t c = 0; c < components; ++c)
      for (std::size_t i = 0; i < shape.inner; ++i, from += bytes)
        std::memcpy(result.data() + ((block * shape.inner + i) * components + c) * bytes, from, bytes);
  samples.values = std::move(result);
}

void pick(Samples& samples, std::initializer_list<int> numbers) {
  const std::size_t bytes = formats::element_bytes(samples.type);
  const std::size_t before = static_cast<std::size_t>(samples.component_count) * bytes;
  const std::size_t count = samples.values.size() / before;
  Array<std::byte> result(count * numbers.size() * bytes);
  std::byte* to = result.data();
  for (std::size_t i = 0; i < count; ++i)
    for (const int number : numbers) {
      std::memcpy(to, samples.values.data() + i * before + static_cast<std::size_t>(number) * bytes, bytes);
      to += bytes;
    }
  samples.values = std::move(result);
  samples.component_count = static_cast<int>(numbers.size());
}

namespace {

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
  const std::vector<GridArray> ghosts = take_ghosts(arrays);
  const std::vector<VectorArray> shapes = shapes_of(arrays);
  const ScalarChoice choice = choose_scalar(path, shapes, field);
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
  set_names(volume, shapes, choice, field);
  volume.field_unit = array.unit;
  if (array.in_cells) volume.notes.push_back("cell data: each value was placed at its cell's centre");
  take_scalar(volume, {array.type, array.component_count, std::move(array.values)}, choice.component);
  finish_volume(volume, path);
  hide_samples(volume, ghosts, points, array.in_cells, path);
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
                     "; expected an array of 3 or 4 components of U8 at points, of: ", names_of(shapes_of(arrays))));
}

}  // namespace

NeutralVolume colors_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field) {
  take_ghosts(arrays);
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
