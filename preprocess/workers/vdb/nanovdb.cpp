#include <nanovdb/util/OpenToNanoVDB.h>

#include "formats/base/text.h"
#include "formats/vdb_grid.h"
#include "preprocess/workers/vdb/hand_out.h"

namespace rhoray::preprocess {
namespace {

/// In single precision, with a note where that changes a value.
openvdb::FloatGrid::Ptr single_precision(ScalarGrid& scalar) {
  if (const auto* floats = std::get_if<openvdb::FloatGrid::Ptr>(&scalar.grid)) return *floats;
  const openvdb::DoubleGrid& doubles = *std::get<openvdb::DoubleGrid::Ptr>(scalar.grid);
  std::uint64_t rounded_count = 0;
  for (auto on = doubles.cbeginValueOn(); on; ++on)
    if (static_cast<double>(static_cast<float>(*on)) != *on && *on == *on) ++rounded_count;
  if (rounded_count != 0)
    scalar.notes.push_back(concat(rounded_count, " values of grid '", scalar.name,
                                  "' are rounded to single precision; packing keeps them as they are"));
  return std::make_shared<openvdb::FloatGrid>(doubles);
}

}  // namespace

void hand_over_nanovdb(ScalarGrid scalar, int descriptor) {
  const openvdb::FloatGrid::Ptr floats = single_precision(scalar);
  scalar.grid = floats;
  formats::VdbGridDescription description;
  description.field = summarize(scalar);
  description.field.type = formats::ElementType::F32;
  description.field_names = scalar.field_names;
  description.world_from_index = scalar.world_from_index;
  const openvdb::Coord first = scalar.box.min();
  description.first_sample = {first.x(), first.y(), first.z()};
  description.sample_count = scalar.sample_count();
  description.is_level_set = scalar.is_level_set();
  description.length_unit = scalar.length_unit;
  description.active_voxel_count = floats->activeVoxelCount();
  description.notes = scalar.notes;

  const nanovdb::GridHandle<nanovdb::HostBuffer> handle =
      nanovdb::openToNanoVDB(*floats, nanovdb::StatsMode::Disable, nanovdb::ChecksumMode::Disable);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(handle.data());
  formats::PackedFileWriter writer(
      descriptor, formats::describe(description),
      {{.name = formats::VdbGrid::buffer_array, .type = formats::ElementType::U8, .shape = {handle.size()}}});
  writer.write_all(formats::VdbGrid::buffer_array, std::span(bytes, handle.size()));
  writer.commit();
}

}  // namespace rhoray::preprocess
