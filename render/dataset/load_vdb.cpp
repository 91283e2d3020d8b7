#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"
#include "render/grid/nanovdb_data.h"

namespace rhoray::render {

std::shared_ptr<const LoadedDataset> load_vdb(const formats::PackedFile& file, const std::string& field, formats::Space,
                                              const Watch&) {
  const formats::VdbGrid grid(file);
  const formats::VdbGridDescription& description = grid.description();
  check_field_name(file, field, {description.field.name});
  const Index3 &first = description.first_sample, cells = description.sample_count - Index3(1, 1, 1);
  Affine world_from_data = description.world_from_index;
  world_from_data.origin =
      world_from_data.point({static_cast<double>(first.x), static_cast<double>(first.y), static_cast<double>(first.z)});
  return std::make_shared<LoadedDataset>(LoadedDataset{
      .file = file,
      .field = description.field,
      .field_names = description.field_names,
      .length_unit = description.length_unit,
      .is_level_set = description.is_level_set,
      .notes = description.notes,
      .world_from_data = world_from_data,
      .bounds_data = Box3(
          {0, 0, 0}, Vec3(static_cast<double>(cells.x), static_cast<double>(cells.y), static_cast<double>(cells.z))),
      .view = nanovdb_data(grid)});
}

}  // namespace rhoray::render
