#include "render/grid/grid_data.h"

#include <bit>
#include <limits>

#include "formats/format_error.h"

namespace rhoray::render {

namespace {

/// Reads each corner of a cell from its address.
template <class Read>
RHORAY_INLINE TrilinearCell corners_of(const SampleSource& source, const Index3& c, const Read& read) {
  const std::uint64_t *x = source.address[0] + c.x, *y = source.address[1] + c.y, *z = source.address[2] + c.z;
  TrilinearCell out;
  for (std::size_t corner = 0; corner < 8; ++corner)
    out.corner[corner] = static_cast<double>(read(x[corner & 1] + y[corner >> 1 & 1] + z[corner >> 2]));
  return out;
}

template <class T>
TrilinearCell fetch_dense(const GridData& grid, const Index3& cell) {
  const T* samples = static_cast<const T*>(grid.source()->samples);
  return corners_of(*grid.source(), cell, [&](std::uint64_t address) { return samples[address]; });
}

template <class T>
TrilinearCell fetch_in_bricks(const GridData& grid, const Index3& cell) {
  const SampleSource& source = *grid.source();
  return corners_of(source, cell, [&](std::uint64_t address) { return sample_in_brick<T>(source, address); });
}

/// The source of a grid that stores only some bricks. Samples of the others are NaN.
template <class T>
SampleSource source_in_bricks(const formats::BrickGrid& grid, const T* samples) {
  static constexpr T no_data[] = {std::numeric_limits<T>::quiet_NaN()};
  const formats::BrickLayout& layout = grid.description().layout;
  const formats::AxisTables& tables = grid.tables();
  const auto size = static_cast<std::uint64_t>(layout.brick_edge * layout.brick_edge * layout.brick_edge);
  return {formats::element_type_of<T>(),
          samples,
          {tables.x.data(), tables.y.data(), tables.z.data()},
          {.slots = grid.brick_slots().data(),
           .shift = std::countr_zero(size),
           .stride = size,
           .stored_count = static_cast<std::uint32_t>(layout.stored_brick_count),
           .last_value = 0,
           .values = no_data},
          layout.sample_count};
}

template <class T>
GridData::Parts parts_of(const formats::BrickGrid& grid, std::size_t field) {
  const formats::GridDescription& description = grid.description();
  const formats::FieldSummary& summary = description.fields[field];
  const T* samples = grid.samples<T>(field).data();
  GridData::Parts parts{.ranges = grid.macro_levels<T>(field),
                        .fetch_cell = fetch_dense<T>,
                        .source = SampleSource(summary.type, samples, grid.tables(), description.layout.sample_count),
                        .values = summary.range,
                        .has_gaps = summary.no_data_count > 0,
                        .memory = nullptr,
                        .packed = grid};
  if constexpr (std::is_floating_point_v<T>)
    if (description.layout.is_sparse) {
      parts.fetch_cell = fetch_in_bricks<T>;
      parts.source = source_in_bricks(grid, samples);
    }
  parts.source->has_gaps = parts.has_gaps;
  return parts;
}

}  // namespace

GridData::GridData(const formats::BrickGrid& grid, std::size_t field)
    : GridData(formats::with_element_type(grid.description().fields[field].type, [&]<class T>(T) -> Parts {
        const formats::FieldSummary& summary = grid.description().fields[field];
        if constexpr (formats::is_exact_as_double<T>)
          if (std::is_floating_point_v<T> || !grid.description().layout.is_sparse) return parts_of<T>(grid, field);
        formats::refuse(
            grid.file().name(), concat("field '", summary.name, "'"), formats::element_name(summary.type),
            grid.description().layout.is_sparse ? "F32 or F64 in a sparse grid" : "a type of at most 32 bits, or F64");
      })) {}

RectilinearGeometry::RectilinearGeometry(const formats::GridDescription& grid) {
  std::array<std::vector<double>, 3> tables;
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < grid.layout.sample_count[axis]; ++i)
      tables[static_cast<std::size_t>(axis)].push_back(grid.position(axis, i));
  tables_ = std::make_shared<const std::array<std::vector<double>, 3>>(std::move(tables));
}

}  // namespace rhoray::render
