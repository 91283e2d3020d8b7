#include "render/grid/grid_data.h"

#include "formats/format_error.h"
#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"

namespace rhoray::render {

RectilinearGeometry::RectilinearGeometry(const formats::GridDescription& grid) {
  std::array<std::vector<double>, 3> tables;
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < grid.layout.sample_count[axis]; ++i)
      tables[static_cast<std::size_t>(axis)].push_back(grid.position(axis, i));
  tables_ = std::make_shared<const std::array<std::vector<double>, 3>>(std::move(tables));
}

namespace {

using Implementation = std::shared_ptr<const LoadedDataset>;

/// Calls make(view) with the kind of view that fits how the grid's samples are stored and
/// positioned.
template <class T, class Make>
Implementation with_view(const formats::BrickGrid& grid, std::size_t field, Make&& make) {
  const bool is_rectilinear = grid.description().is_rectilinear();
  if constexpr (std::is_floating_point_v<T>) {
    if (grid.description().layout.is_sparse)
      return is_rectilinear ? make(SparseRectilinearGridData<T>(grid, field)) : make(SparseGridData<T>(grid, field));
  }
  return is_rectilinear ? make(RectilinearGridData<T>(grid, field)) : make(GridData<T>(grid, field));
}

}  // namespace

Implementation load_grid(const formats::PackedFile& file, const std::string& field) {
  const formats::BrickGrid grid(file);
  const formats::GridDescription& description = grid.description();
  std::vector<std::string> names;
  for (const formats::FieldSummary& summary : description.fields) names.push_back(summary.name);
  check_field_name(file, field, names);
  const std::size_t chosen = field.empty() ? 0 : *grid.find_field(field);
  const formats::FieldSummary& summary = description.fields[chosen];

  Box3 bounds;
  for (const Index3& sample : {Index3(0, 0, 0), description.macro.leaf_count})
    bounds.extendBy(
        Vec3(description.position(0, sample.x), description.position(1, sample.y), description.position(2, sample.z)));
  const auto make = [&](auto view) {
    return std::make_shared<const LoadedDataset>(LoadedDataset{.file = file,
                                                               .field = summary,
                                                               .field_names = names,
                                                               .length_unit = description.length_unit,
                                                               .world_from_data = description.world_from_grid,
                                                               .bounds_data = bounds,
                                                               .view = std::move(view)});
  };
  return formats::with_element_type(summary.type, [&](auto sample) -> Implementation {
    using T = decltype(sample);
    if constexpr (std::is_integral_v<T> && sizeof(T) == 8)
      formats::refuse(file.name(), "field", formats::element_name(summary.type), "a type of at most 32 bits, or F64");
    else
      return with_view<T>(grid, chosen, make);
  });
}

}  // namespace rhoray::render
