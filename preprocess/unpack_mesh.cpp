#include "preprocess/unpack_mesh.h"

#include <utility>

namespace rhoray::preprocess {

NeutralMesh unpack_mesh(const formats::TetMesh& packed) {
  const formats::TetMeshDescription& description = packed.description();
  NeutralMesh mesh;
  mesh.length_unit = description.length_unit;
  mesh.points.reserve(packed.points().size());
  for (const auto& p : packed.points())
    mesh.points.push_back({description.origin.x + p[0], description.origin.y + p[1], description.origin.z + p[2]});
  mesh.cells.reserve(packed.cells().size());
  mesh.cell_ids.reserve(packed.cells().size());
  for (const auto& cell : packed.cells()) {
    mesh.cell_ids.push_back(packed.cell_id(mesh.cells.size()));
    mesh.cells.push_back({cell[0], cell[1], cell[2], cell[3]});
  }
  for (std::size_t f = 0; f < description.fields.size(); ++f) {
    const formats::FieldSummary& summary = description.fields[f];
    NeutralField field{.name = summary.name,
                       .unit = summary.unit,
                       .component_count = 1,
                       .was_single_precision = summary.type == formats::ElementType::F32,
                       .values = {}};
    if (field.was_single_precision) {
      const std::span<const float> values = packed.values<float>(f);
      field.values.assign(values.begin(), values.end());
    } else {
      const std::span<const double> values = packed.values<double>(f);
      field.values.assign(values.begin(), values.end());
    }
    mesh.point_fields.push_back(std::move(field));
  }
  return mesh;
}

}  // namespace rhoray::preprocess
