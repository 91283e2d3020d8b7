#include "formats/color_grid.h"

#include "formats/base/text.h"
#include "formats/details/details.h"
#include "formats/details/grid_details.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

using details::Json;

ColorGridDescription read_description(const PackedFile& file) {
  if (file.description().kind != ColorGrid::kind)
    refuse(file.name(), "header, __metadata__, kind", concat("'", file.description().kind, "'"), "'colors'");
  const Json json = details::parse(file);
  const details::Reader reader(json, file.name(), "details");
  ColorGridDescription grid;
  grid.layout = details::read_layout(reader, 1);
  grid.world_from_grid = details::read_affine(reader);
  grid.length_unit = reader.text("length_unit");
  grid.space = details::read_space(reader);
  grid.component_count = static_cast<int>(reader.count("component_count", 3, 4));
  grid.provenance = details::read_provenance(reader.object("provenance"));
  return grid;
}

std::vector<std::uint64_t> shape_of(const ColorGridDescription& grid) {
  std::vector<std::uint64_t> shape = grid.layout.shape();
  shape.push_back(static_cast<std::uint64_t>(grid.component_count));
  return shape;
}

}  // namespace

ColorGrid::ColorGrid(PackedFile file) : file_(std::move(file)), description_(read_description(file_)) {
  texels_ = file_.array<std::uint8_t>("texels", shape_of(description_));
  // Created only here: the tables are smaller than the texels, whose size has just been checked.
  tables_ = std::make_shared<const AxisTables>(description_.layout);
}

Box3 ColorGridDescription::box_grid() const {
  const Vec3 half(0.5, 0.5, 0.5);
  return {-half, Vec3(layout.sample_count) - half};
}

Box3 ColorGridDescription::bounds() const {
  const Box3 box = box_grid();
  Box3 bounds;
  for (int corner = 0; corner < 8; ++corner)
    bounds.extendBy(world_from_grid.point(
        {corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z}));
  return bounds;
}

std::vector<ArraySpec> color_grid_arrays(const ColorGridDescription& grid) {
  return {{.name = "texels", .type = ElementType::U8, .shape = shape_of(grid), .alignment = 4096}};
}

FileDescription describe(const ColorGridDescription& grid) {
  Json json{{"sample_count", details::index_json(grid.layout.sample_count)},
            {"brick_edge", grid.layout.brick_edge},
            {"superbrick_edge", details::index_json(grid.layout.superbrick_edge)},
            {"world_from_grid", details::affine_json(grid.world_from_grid)},
            {"length_unit", grid.length_unit},
            {"component_count", grid.component_count},
            {"provenance", details::provenance_json(grid.provenance)}};
  const bool has_space = grid.space != Space::unknown;
  if (has_space) json["space"] = space_word(grid.space);
  return {.kind = ColorGrid::kind, .required = {}, .details = details::dump(json), .minor_version = has_space ? 6 : 4};
}

}  // namespace rhoray::formats
