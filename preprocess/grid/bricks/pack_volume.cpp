#include "preprocess/pack_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "preprocess/grid/bricks/convert.h"
#include "preprocess/grid/bricks/lattice_choice.h"
#include "preprocess/grid/bricks/sparse_bricks.h"
#include "preprocess/grid/bricks/write_samples.h"
#include "preprocess/values/build_levels.h"
#include "preprocess/values/choose_shape.h"
#include "preprocess/values/isosurface_profile.h"
#include "preprocess/values/summarize.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

formats::BrickLayout chosen_layout(const Index3& sample_count, const PackVolumeOptions& options) {
  switch (options.order) {
    case SampleOrder::linear:
      return formats::BrickLayout::linear(sample_count);
    case SampleOrder::sparse: {
      const std::int64_t edge = options.brick_edge.value_or(8);
      if (!formats::BrickLayout::is_sparse_edge(edge))
        throw Error(ErrorCode::usage, concat("brick edge: found ", edge, "; expected 2, 4, 8, 16, 32 or 64 where only ",
                                             "some bricks are kept"));
      return formats::BrickLayout::sparse(sample_count, 0, edge);
    }
    case SampleOrder::bricks:
      break;
  }
  return bricked_layout(sample_count, options.brick_edge.value_or(4), options.largest_superbrick);
}

void check_samples(const NeutralVolume& volume, const std::string& source_name) {
  const Index3& n = volume.sample_count;
  constexpr std::int64_t largest_axis = std::int64_t{1} << 20;  // what a reader accepts
  for (const std::int64_t samples : {n.x, n.y, n.z})
    if (samples < 2 || samples > largest_axis)
      throw Error(ErrorCode::invalid, concat(source_name, ": found ", n.x, " x ", n.y, " x ", n.z,
                                             " samples; expected 2 to ", largest_axis, " on every axis"));
  const auto bytes = checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                                      static_cast<std::uint64_t>(n.z), formats::element_bytes(volume.type)});
  if (!bytes || *bytes != volume.samples.size())
    throw Error(ErrorCode::invalid,
                concat(source_name, ": found ", volume.samples.size(), " bytes of samples; expected ", n.x, " x ", n.y,
                       " x ", n.z, " of ", formats::element_name(volume.type)));
}

void check_axes(const NeutralVolume& volume, const std::string& source_name) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& table = volume.axes[static_cast<std::size_t>(axis)];
    if (table.empty()) continue;
    const std::string place = concat(source_name, ", positions along ", "xyz"[axis]);
    if (table.size() != static_cast<std::size_t>(volume.sample_count[axis]))
      throw Error(ErrorCode::invalid,
                  concat(place, ": found ", table.size(), " of them; expected ", volume.sample_count[axis]));
    for (std::size_t i = 0; i < table.size(); ++i)
      if (!std::isfinite(table[i]) || (i > 0 && !(table[i] > table[i - 1])))
        throw Error(ErrorCode::invalid,
                    concat(place, ", sample ", i, ": found ", table[i], "; expected a finite number",
                           i > 0 ? concat(" above ", table[i - 1]) : std::string()));
    if (!std::isfinite(table.back() - table.front()))
      throw Error(ErrorCode::invalid, concat(place, ": found ", table.front(), " to ", table.back(),
                                             "; expected an axis of finite length"));
  }
}

/// A packed grid holds no 64-bit integers.
ElementType stored_type(const NeutralVolume& volume, const PackVolumeOptions& options) {
  const ElementType type = options.type.value_or(volume.type);
  if (type != ElementType::U64 && type != ElementType::I64) return type;
  if (options.type)
    throw Error(ErrorCode::usage, concat("type: found ", formats::element_name(type),
                                         "; expected U8, I8, U16, I16, U32, I32, F32 or F64"));
  return ElementType::F64;
}

std::string name_of(const NeutralVolume& volume) {
  return volume.field_name.empty() ? "value" : volume.field_name;
}

/// Several fields need one lattice, and different names.
void check_one_lattice(std::span<const NeutralVolume> fields, const std::string& source_name) {
  for (std::size_t f = 1; f < fields.size(); ++f) {
    const NeutralVolume &first = fields[0], &field = fields[f];
    if (field.sample_count != first.sample_count || field.world_from_grid != first.world_from_grid ||
        field.axes != first.axes || field.length_unit != first.length_unit)
      throw Error(ErrorCode::invalid, concat(source_name, ", field '", name_of(field),
                                             "': found a different lattice; expected that of '", name_of(first), "'"));
    for (std::size_t other = 0; other < f; ++other)
      if (name_of(fields[other]) == name_of(field))
        throw Error(ErrorCode::invalid,
                    concat(source_name, ": found two fields '", name_of(field), "'; expected names that differ"));
  }
}

/// True when position i is exactly first + i * step.
bool is_uniform(const std::vector<double>& positions) {
  const double first = positions[0], step = positions[1] - first;
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (positions[i] != first + static_cast<double>(i) * step) return false;
  return true;
}

/// Stores positions along the axes. Uniform ones become part of the map, where they cost rays
/// nothing.
void take_axes(const NeutralVolume& volume, formats::GridDescription& grid) {
  const Affine& map = volume.world_from_grid;
  const std::array<Vec3, 3> from{map.x_axis, map.y_axis, map.z_axis};
  std::array<Vec3, 3> to = from;
  Vec3 origin = map.origin;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double>& positions = volume.axes[axis];
    if (positions.empty()) continue;
    if (!is_uniform(positions)) {
      grid.axes[axis] = positions;
      continue;
    }
    origin += positions[0] * from[axis];
    to[axis] = (positions[1] - positions[0]) * from[axis];
  }
  grid.world_from_grid = {to[0], to[1], to[2], origin};
}

/// Returns a view of the same samples, or a converted copy where the type changes.
NeutralVolume stored_volume(const NeutralVolume& volume, const PackVolumeOptions& options,
                            const std::string& source_name) {
  NeutralVolume stored;
  stored.sample_count = volume.sample_count;
  stored.type = volume.type;
  stored.samples = volume.samples;
  align_samples(stored);
  convert_samples(stored, stored_type(volume, options), source_name);
  return stored;
}

/// Calls act with the samples as a span of their type.
template <class Act>
void with_samples(const NeutralVolume& stored, Act&& act) {
  formats::with_element_type(stored.type, [&]<class T>(T) {
    if constexpr (sizeof(T) == 8 && std::is_integral_v<T>)
      throw Error(ErrorCode::internal, "64-bit integers reached the packer of samples");
    else
      act(std::span(reinterpret_cast<const T*>(stored.samples.data()), stored.samples.size() / sizeof(T)));
  });
}

/// Returns the bricks that a sparse layout keeps: those in which one of the fields has data.
Array<std::uint64_t> choose_bricks(const std::vector<NeutralVolume>& fields, const formats::BrickLayout& layout,
                                   const std::string& source_name) {
  Array<std::uint8_t> holds_data(static_cast<std::size_t>(volume(layout.brick_count())));
  for (const NeutralVolume& field : fields)
    with_samples(field, [&]<class T>(std::span<const T> samples) {
      if constexpr (std::is_floating_point_v<T>)
        mark_bricks_with_data(samples, layout, std::span(holds_data));
      else
        throw Error(
            ErrorCode::usage,
            concat(source_name, ": found samples of type ", formats::element_name(field.type),
                   "; expected F32 or F64, in which a sample may have no data, where only some bricks are kept"),
            "keep all bricks, or choose one of these types");
    });
  Array<std::uint64_t> bricks = bricks_of_slots(holds_data);
  if (bricks.size() >= formats::BrickGrid::no_brick)
    throw Error(ErrorCode::usage,
                concat("brick edge: found ", layout.brick_edge, ", which makes ", bricks.size(),
                       " bricks with data; expected fewer than ", formats::BrickGrid::no_brick),
                "choose larger bricks");
  return bricks;
}

using WriteLevels = std::function<void(formats::PackedFileWriter&)>;

/// Summarises a field and builds its levels; the returned function writes them.
WriteLevels prepare_field(const NeutralVolume& source, const NeutralVolume& stored, formats::GridDescription& grid,
                          const Progress& progress) {
  const std::size_t field = grid.fields.size();
  WriteLevels write;
  with_samples(stored, [&]<class T>(std::span<const T> samples) {
    grid.fields.push_back(summarize(samples, name_of(source), source.field_unit, progress));
    grid.fields.back().label_names = source.label_names;
    profile_isosurfaces(samples, {source.sample_count, grid.world_from_grid, grid.axes}, grid.fields.back());
    auto levels = std::make_shared<const Levels<T>>(build_grid_levels(samples, grid.macro, progress));
    write = [levels, field](formats::PackedFileWriter& writer) {
      for (std::size_t l = 0; l < levels->size(); ++l)
        writer.write_all(concat(formats::macro_prefix(field), l + 1), std::span<const T>((*levels)[l]));
    };
  });
  return write;
}

/// Takes the arrays of samples out of a grid's arrays and returns them, field by field.
std::vector<formats::ArraySpec> take_samples(const formats::GridDescription& grid,
                                             std::vector<formats::ArraySpec>& arrays) {
  std::vector<formats::ArraySpec> taken;
  for (std::size_t field = 0; field < grid.fields.size(); ++field) {
    const auto found = std::find_if(arrays.begin(), arrays.end(), [&](const formats::ArraySpec& array) {
      return array.name == formats::samples_array(field);
    });
    taken.push_back(*found);
    arrays.erase(found);
  }
  return taken;
}

std::uint64_t sample_bytes(const formats::GridDescription& grid) {
  std::uint64_t samples = 1, bytes = 0;
  for (const std::uint64_t n : grid.layout.shape()) samples *= n;
  for (const formats::FieldSummary& field : grid.fields) bytes += samples * formats::element_bytes(field.type);
  return bytes;
}

}  // namespace

namespace {

PackVolumeReport write_fields(std::span<const NeutralVolume> fields, const formats::Destination& destination,
                              const PackVolumeOptions& options, const Progress& progress) {
  RHORAY_CHECK(!fields.empty());
  RHORAY_CHECK(!options.leaves_out_samples || (options.order == SampleOrder::linear && !options.type));
  const NeutralVolume& first = fields.front();
  const std::string source_name = options.source_name.empty() ? "volume" : options.source_name;
  PackVolumeReport report;
  formats::GridDescription& grid = report.description;
  grid.layout = chosen_layout(first.sample_count, options);
  for (const NeutralVolume& field : fields) check_samples(field, source_name);
  check_axes(first, source_name);
  check_one_lattice(fields, source_name);
  take_axes(first, grid);
  check_frame(first.world_from_grid, source_name);
  check_frame(grid.world_from_grid, source_name);
  grid.length_unit = first.length_unit;
  grid.space = first.space;
  grid.macro =
      choose_macro_shape(first.sample_count - Index3(1, 1, 1), options.macro_factor, options.macro_level_count);
  grid.provenance = {.source_name = options.source_name, .source_checksum = {}, .command = options.command};

  std::vector<NeutralVolume> stored;
  stored.reserve(fields.size());
  for (const NeutralVolume& field : fields) stored.push_back(stored_volume(field, options, source_name));
  Array<std::uint64_t> bricks;
  if (grid.layout.is_sparse) {
    bricks = choose_bricks(stored, grid.layout, source_name);
    grid.layout.stored_brick_count = bricks.size();
  }
  std::vector<WriteLevels> write_levels;
  for (std::size_t f = 0; f < fields.size(); ++f)
    write_levels.push_back(prepare_field(fields[f], stored[f], grid, progress));

  std::vector<formats::ArraySpec> arrays = formats::grid_arrays(grid);
  if (options.leaves_out_samples) report.left_out = take_samples(grid, arrays);
  formats::PackedFileWriter writer(destination, formats::describe(grid), arrays,
                                   {.replace_existing = options.replace_existing});
  ProgressMeter writing(progress, "writing samples (bytes)", options.leaves_out_samples ? 0 : sample_bytes(grid));
  formats::write_axes(grid, writer);
  if (grid.layout.is_sparse)
    writer.write_all("bricks", std::span<const std::uint32_t>(slots_of_bricks(
                                   bricks, static_cast<std::size_t>(volume(grid.layout.brick_count())))));
  for (std::size_t f = 0; f < fields.size(); ++f) {
    with_samples(stored[f], [&]<class T>(std::span<const T> samples) {
      if (options.leaves_out_samples) return;
      const std::string array = formats::samples_array(f);
      if constexpr (std::is_floating_point_v<T>)
        if (grid.layout.is_sparse) return write_sparse_samples(samples, grid.layout, bricks, array, writer, writing);
      write_samples(samples, grid.layout, array, writer, writing);
    });
    write_levels[f](writer);
  }
  ProgressMeter sealing(progress, "sealing", 1);
  report.file_bytes = writer.commit();
  sealing.add(1);
  return report;
}

}  // namespace

PackVolumeReport pack_grid(std::span<const NeutralVolume> fields, const formats::Destination& destination,
                           const PackVolumeOptions& options, const Progress& progress) {
  const DefaultFloatingPoint default_floating_point;
  return write_fields(fields, destination, options, progress);
}

PackVolumeReport pack_volume(const NeutralVolume& volume, const formats::Destination& destination,
                             const PackVolumeOptions& options, const Progress& progress) {
  return pack_grid(std::span(&volume, 1), destination, options, progress);
}

}  // namespace rhoray::preprocess
