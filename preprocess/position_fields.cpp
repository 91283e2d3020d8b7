#include "preprocess/position_fields.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "formats/base/text.h"
#include "formats/shape_field.h"
#include "preprocess/boundary_distance.h"
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

/// The faces that one cell has alone.
std::vector<std::array<std::uint64_t, 3>> boundary_of(const NeutralMesh& mesh) {
  const std::vector<inspect::CellFace> faces = inspect::sorted_faces(mesh);
  std::vector<std::array<std::uint64_t, 3>> boundary;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool is_shared = (i > 0 && faces[i - 1].vertices == faces[i].vertices) ||
                           (i + 1 < faces.size() && faces[i + 1].vertices == faces[i].vertices);
    if (!is_shared) boundary.push_back(faces[i].vertices);
  }
  return boundary;
}

/// Cells whose corners all have distance 0.
std::size_t cells_without_distance(const NeutralMesh& mesh, const Array<double>& distances) {
  return static_cast<std::size_t>(std::count_if(mesh.cells.begin(), mesh.cells.end(), [&](const auto& cell) {
    return std::all_of(cell.begin(), cell.end(), [&](std::uint64_t vertex) { return distances[vertex] == 0; });
  }));
}

}  // namespace

bool has_varying_field(const NeutralMesh& mesh) {
  return std::any_of(mesh.point_fields.begin(), mesh.point_fields.end(), varies) ||
         std::any_of(mesh.cell_fields.begin(), mesh.cell_fields.end(),
                     [](const NeutralField& field) { return field.name != "region" && varies(field); });
}

void add_position_fields(NeutralMesh& mesh) {
  std::vector<bool> is_used(mesh.points.size(), false);
  for (const auto& cell : mesh.cells)
    for (const std::uint64_t vertex : cell) is_used[vertex] = true;
  std::vector<NeutralField> fields;
  bool any_inside = false;
  std::size_t flat_cells = 0;
  if (const auto boundary = boundary_of(mesh); !boundary.empty()) {
    NeutralField distance;
    distance.name = formats::boundary_distance;
    distance.unit = mesh.length_unit;
    distance.values = distances_to(boundary, mesh.points);
    NeutralField interior;
    interior.name = "interior";
    for (std::size_t p = 0; p < mesh.points.size(); ++p) {
      interior.values.push_back(distance.values[p] > 0 ? 1 : 0);
      any_inside = any_inside || (is_used[p] && distance.values[p] > 0);
    }
    flat_cells = cells_without_distance(mesh, distance.values);
    if (any_inside) {
      fields.push_back(std::move(distance));
      fields.push_back(std::move(interior));
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    NeutralField& field = fields.emplace_back();
    field.name = std::string(1, "xyz"[axis]);
    field.unit = mesh.length_unit;
    field.was_single_precision = false;
    for (const auto& point : mesh.points) field.values.push_back(point[axis]);
  }
  mesh.point_fields.insert(mesh.point_fields.begin(), std::make_move_iterator(fields.begin()),
                           std::make_move_iterator(fields.end()));
  mesh.notes.push_back(
      any_inside ? "no field varies: boundary_distance (of each point to the mesh's boundary), interior (0 at "
                   "the boundary, 1 inside), x, y and z were added"
                 : "no field varies: the coordinates x, y and z were added");
  if (any_inside && flat_cells > 0)
    mesh.notes.push_back(concat(flat_cells, " of ", mesh.cells.size(),
                                " tetrahedra have all corners on the boundary: boundary_distance is 0 in them, so its "
                                "isosurfaces leave thin parts out; fill with --max-volume for points inside them"));
}

}  // namespace rhoray::preprocess
