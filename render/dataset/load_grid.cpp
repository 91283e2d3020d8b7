#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"

namespace rhoray::render {

std::shared_ptr<const LoadedDataset> load_grid(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const Watch&) {
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
  const bool is_rectilinear = description.is_rectilinear();
  const bool is_placed = description.space != formats::Space::unknown;
  return std::make_shared<LoadedDataset>(LoadedDataset{
      .file = file,
      .field = summary,
      .fields = description.fields,
      .field_names = names,
      .length_unit = description.length_unit,
      .space = is_placed && world != formats::Space::unknown ? world : description.space,
      .world_from_data = formats::in_space(description.world_from_grid, description.space, world),
      .bounds_data = bounds,
      .view = is_rectilinear ? DataView(RectilinearGrid(grid, chosen)) : DataView(UniformGrid(grid, chosen))});
}

}  // namespace rhoray::render
