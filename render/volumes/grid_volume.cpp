#include "formats/format_error.h"
#include "render/volumes/load_view.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

std::shared_ptr<const VolumeImplementation> load_grid(const formats::PackedFile& file, const std::string& field) {
  const formats::BrickGrid grid(file);
  const formats::GridDescription& description = grid.description();
  std::vector<std::string> names;
  for (const formats::FieldSummary& summary : description.fields) names.push_back(summary.name);
  check_field_name(file, field, names);
  const std::size_t chosen = field.empty() ? 0 : *grid.find_field(field);
  const formats::FieldSummary& summary = description.fields[chosen];

  const Index3 cells = description.macro.leaf_count;
  const auto make = [&](auto view) {
    return std::make_shared<VolumeImplementation>(VolumeImplementation{
        .file = file,
        .field = summary,
        .field_names = names,
        .length_unit = description.length_unit,
        .world_from_volume = description.world_from_grid,
        .bounds_volume = Box3(
            {0, 0, 0}, Vec3(static_cast<double>(cells.x), static_cast<double>(cells.y), static_cast<double>(cells.z))),
        .view = std::move(view)});
  };
  return formats::with_element_type(
      summary.type, [&](auto sample) -> std::shared_ptr<const VolumeImplementation> {
        using T = decltype(sample);
        if constexpr (std::is_integral_v<T> && sizeof(T) == 8)
          formats::refuse(file.name(), "field", formats::element_name(summary.type),
                          "a type of at most 32 bits, or F64");
        else
          return make(GridVolume<T>(grid, chosen));
      });
}

}  // namespace rhoray::render
