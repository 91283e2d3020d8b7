#include "preprocess/position_fields.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "preprocess/inspect/finding.h"

namespace rhoray::preprocess {
namespace {

bool varies(const NeutralField& field) {
  const auto components = static_cast<std::size_t>(field.component_count);
  for (std::size_t c = 0; c < components; ++c) {
    double first = std::nan("");
    for (std::size_t i = c; i < field.values.size(); i += components) {
      const double value = field.values[i];
      if (!std::isfinite(value)) continue;
      if (std::isnan(first)) first = value;
      if (value != first) return true;
    }
  }
  return false;
}

/// 0 at the points of faces that one cell has alone, 1 elsewhere.
NeutralField interior(const NeutralMesh& mesh) {
  NeutralField field;
  field.name = "interior";
  field.values.assign(mesh.points.size(), 1);
  const std::vector<inspect::CellFace> faces = inspect::sorted_faces(mesh);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool is_shared = (i > 0 && faces[i - 1].vertices == faces[i].vertices) ||
                           (i + 1 < faces.size() && faces[i + 1].vertices == faces[i].vertices);
    if (is_shared) continue;
    for (const std::uint64_t vertex : faces[i].vertices) field.values[vertex] = 0;
  }
  return field;
}

}  // namespace

bool has_varying_field(const NeutralMesh& mesh) {
  return std::any_of(mesh.point_fields.begin(), mesh.point_fields.end(), varies) ||
         std::any_of(mesh.cell_fields.begin(), mesh.cell_fields.end(), varies);
}

void add_position_fields(NeutralMesh& mesh) {
  std::vector<bool> is_used(mesh.points.size(), false);
  for (const auto& cell : mesh.cells)
    for (const std::uint64_t vertex : cell) is_used[vertex] = true;
  std::vector<NeutralField> fields;
  NeutralField inside = interior(mesh);
  bool any_inside = false;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) any_inside = any_inside || (is_used[p] && inside.values[p] == 1);
  if (any_inside) fields.push_back(std::move(inside));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    NeutralField& field = fields.emplace_back();
    field.name = std::string(1, "xyz"[axis]);
    field.unit = mesh.length_unit;
    field.was_single_precision = false;
    for (const auto& point : mesh.points) field.values.push_back(point[axis]);
  }
  mesh.point_fields.insert(mesh.point_fields.begin(), std::make_move_iterator(fields.begin()),
                           std::make_move_iterator(fields.end()));
  mesh.notes.push_back(any_inside ? "no field varies: interior (0 at the boundary, 1 inside), x, y and z were added"
                                  : "no field varies: the coordinates x, y and z were added");
}

}  // namespace rhoray::preprocess
