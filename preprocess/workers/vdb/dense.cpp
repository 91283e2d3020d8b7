#include <openvdb/tools/Dense.h>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "preprocess/workers/vdb/hand_out.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// 64-bit integers are held in double precision, where each is exact.
ElementType dense_type(const ScalarGrid& grid) {
  return grid.source_type == ElementType::I64 ? ElementType::F64 : grid.source_type;
}

std::uint64_t checked_bytes(const ScalarGrid& grid, std::uint64_t limit_bytes, const std::filesystem::path& path) {
  const Index3 n = grid.sample_count();
  const auto bytes = checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                                      static_cast<std::uint64_t>(n.z), formats::element_bytes(dense_type(grid))});
  if (bytes && *bytes <= limit_bytes) return *bytes;
  throw Error(ErrorCode::resource,
              concat(path.string(), ": grid '", grid.name, "' spans ", n.x, " x ", n.y, " x ", n.z, " samples, ",
                     bytes ? concat(*bytes) : "2^64 or more", " bytes when dense; expected at most ", limit_bytes),
              concat("`rhoray render ", path.string(), "` shows it without packing; --memory allows more"));
}

}  // namespace

NeutralVolume dense_volume(const ScalarGrid& scalar, std::uint64_t limit_bytes, const std::filesystem::path& path) {
  NeutralVolume volume;
  volume.sample_count = scalar.sample_count();
  volume.type = dense_type(scalar);
  volume.owned_samples.resize(checked_bytes(scalar, limit_bytes, path));
  volume.samples = volume.owned_samples;
  formats::with_element_type(volume.type, [&]<class T>(T) {
    using Samples = openvdb::tools::Dense<T, openvdb::tools::LayoutXYZ>;  // x fastest
    Samples samples(scalar.box, reinterpret_cast<T*>(volume.owned_samples.data()));
    std::visit([&](const auto& grid) { openvdb::tools::copyToDense(*grid, samples); }, scalar.grid);
  });
  const openvdb::Coord first = scalar.box.min();
  volume.world_from_grid = scalar.world_from_index;
  volume.world_from_grid.origin = scalar.world_from_index.point(
      {static_cast<double>(first.x()), static_cast<double>(first.y()), static_cast<double>(first.z())});
  volume.length_unit = scalar.length_unit;
  volume.field_name = scalar.name;
  volume.field_unit = scalar.field_unit;
  for (const std::string& name : scalar.field_names)
    if (name != scalar.name) volume.other_fields.push_back(name);
  volume.notes = scalar.notes;
  if (!scalar.inactive_is_no_data)
    volume.notes.push_back(concat("inactive voxels of grid '", scalar.name,
                                  "' have its background value; the samples extend one voxel beyond the active ones"));
  return volume;
}

}  // namespace rhoray::preprocess
