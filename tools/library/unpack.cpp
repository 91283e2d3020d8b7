#include "rhoray/unpack.h"

#include <cstring>
#include <limits>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/base/stopping.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "preprocess/unpack_mesh.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

namespace {

/// Copies all samples, x fastest.
template <class T>
void copy_samples(const formats::BrickGrid& grid, std::size_t field, std::byte* to, const rhoray::Watch& watch) {
  const formats::BrickLayout& layout = grid.description().layout;
  const Index3& count = layout.sample_count;
  const std::span<const T> samples = grid.samples<T>(field);
  std::optional<formats::SparseAddress> sparse;
  if (layout.is_sparse) sparse.emplace(layout, grid.tables(), grid.brick_slots());
  const auto row_count = static_cast<std::size_t>(count.y * count.z);
  ProgressMeter meter(watch.progress, "copying (rows)", row_count);
  parallel_for(row_count, 16, [&](const IndexRange& rows) {
    for (std::size_t row = rows.begin(); row < rows.end(); ++row) {
      end_if_stopped(watch.stop);
      const auto j = static_cast<std::int64_t>(row) % count.y, k = static_cast<std::int64_t>(row) / count.y;
      std::byte* target = to + row * static_cast<std::size_t>(count.x) * sizeof(T);
      for (std::int64_t i = 0; i < count.x; ++i, target += sizeof(T)) {
        const std::uint64_t address = sparse ? (*sparse)(i, j, k) : grid.tables().address(i, j, k);
        const T value =
            address == formats::SparseAddress::no_sample ? std::numeric_limits<T>::quiet_NaN() : samples[address];
        std::memcpy(target, &value, sizeof(T));
      }
    }
    meter.add(rows.size());
  });
}

void take_fields(std::vector<preprocess::NeutralField>& fields, bool is_of_cells, MeshCopy& copy) {
  for (preprocess::NeutralField& field : fields)
    copy.fields.push_back({.name = field.name,
                           .unit = field.unit,
                           .is_of_cells = is_of_cells,
                           .is_single_precision = field.was_single_precision,
                           .values = {field.values.begin(), field.values.end()}});
}

}  // namespace

GridCopy unpack_grid(const Dataset& grid, std::string_view field, const Watch& watch) {
  return inside::guarded([&] {
    const rhoray::Watch watched = inside::inside_of(watch);
    const Dataset::Implementation& data = grid.implementation();
    if (grid.kind() != DataKind::grid) inside::refuse("unpack_grid: ", data.first().file().name(), " is no grid");
    const formats::BrickGrid packed(data.first().file());
    const std::size_t number = packed.find_field(data.field(field).name).value();
    const Index3& count = packed.description().layout.sample_count;
    const formats::ElementType type = packed.description().fields[number].type;
    GridCopy copy{.shape = {count.z, count.y, count.x}, .type = static_cast<ElementType>(type)};
    copy.samples.resize(static_cast<std::size_t>(volume(count)) * formats::element_bytes(type));
    formats::with_element_type(type,
                               [&]<class T>(T) { copy_samples<T>(packed, number, copy.samples.data(), watched); });
    return copy;
  });
}

MeshCopy unpack_mesh(const Dataset& mesh, const Watch& watch) {
  return inside::guarded([&] {
    const rhoray::Watch watched = inside::inside_of(watch);
    const render::Dataset& data = mesh.implementation().first();
    if (mesh.kind() != DataKind::tetrahedra)
      inside::refuse("unpack_mesh: ", data.file().name(), " holds no tetrahedra");
    preprocess::NeutralMesh unpacked = preprocess::unpack_mesh(formats::TetMesh(data.file(), watched), watched);
    MeshCopy copy;
    copy.points.assign(unpacked.points.begin(), unpacked.points.end());
    copy.tetrahedra.assign(unpacked.cells.begin(), unpacked.cells.end());
    take_fields(unpacked.point_fields, false, copy);
    take_fields(unpacked.cell_fields, true, copy);
    return copy;
  });
}

}  // namespace rhoray::v0_1
