#include "preprocess/mesh/position_fields.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "formats/base/text.h"
#include "formats/shape_field.h"
#include "preprocess/mesh/boundary_distance.h"
#include "preprocess/mesh/inspect/finding.h"
#include "preprocess/pack_mesh.h"

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

/// Returns the faces that belong to one cell alone.
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

/// Adds a point at the centre of some corners; fields get the mean of their values there.
std::uint64_t add_middle(NeutralMesh& mesh, const std::array<std::uint64_t, 4>& corners) {
  std::array<double, 3> middle{};
  for (const std::uint64_t corner : corners)
    for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] += 0.25 * mesh.points[corner][axis];
  mesh.points.push_back(middle);
  for (NeutralField& field : mesh.point_fields) {
    const auto components = static_cast<std::size_t>(field.component_count);
    for (std::size_t c = 0; c < components; ++c) {
      double mean = 0;
      for (const std::uint64_t corner : corners) mean += 0.25 * field.values[components * corner + c];
      field.values.push_back(mean);
    }
  }
  return mesh.points.size() - 1;
}

/// Adds a cell that is part of another one.
void add_part(NeutralMesh& mesh, std::size_t whole, const std::array<std::uint64_t, 4>& part) {
  mesh.cells.push_back(part);
  mesh.cell_ids.push_back(mesh.cell_ids[whole]);
  for (NeutralField& field : mesh.cell_fields) {
    const auto components = static_cast<std::size_t>(field.component_count);
    for (std::size_t c = 0; c < components; ++c) field.values.push_back(field.values[components * whole + c]);
  }
}

/// Cuts cells whose corners all lie on the boundary in four; otherwise a field that is 0 there
/// could not show them. Their faces stay unchanged, so neighbours are not affected.
/// @return  number of cells cut
std::size_t cut_cells_between_boundaries(NeutralMesh& mesh, std::span<const std::array<std::uint64_t, 3>> boundary) {
  std::vector<bool> is_on_boundary(mesh.points.size(), false);
  for (const auto& face : boundary)
    for (const std::uint64_t corner : face) is_on_boundary[corner] = true;
  if (mesh.cell_ids.empty()) {
    mesh.cell_ids.resize(mesh.cells.size());
    std::iota(mesh.cell_ids.begin(), mesh.cell_ids.end(), std::uint64_t{0});
  }
  std::size_t cut = 0;
  const std::size_t cell_count = mesh.cells.size();
  for (std::size_t c = 0; c < cell_count; ++c) {
    const std::array<std::uint64_t, 4> corners = mesh.cells[c];
    if (!std::all_of(corners.begin(), corners.end(), [&](std::uint64_t v) { return is_on_boundary[v]; })) continue;
    const std::uint64_t middle = add_middle(mesh, corners);
    for (std::size_t replaced = 0; replaced < 4; ++replaced) {
      std::array<std::uint64_t, 4> part = corners;
      part[replaced] = middle;
      if (replaced == 0)
        mesh.cells[c] = part;
      else
        add_part(mesh, c, part);
    }
    ++cut;
  }
  return cut;
}

bool names_parts(const NeutralField& cell_field) {
  constexpr std::string_view names[] = {"region", "block", "physical",
                                        "entity"};  // names given by filling and by the readers
  return std::find(std::begin(names), std::end(names), cell_field.name) != std::end(names);
}

}  // namespace

bool has_varying_field(const NeutralMesh& mesh) {
  return std::any_of(mesh.point_fields.begin(), mesh.point_fields.end(), varies) ||
         std::any_of(mesh.cell_fields.begin(), mesh.cell_fields.end(),
                     [](const NeutralField& field) { return !names_parts(field) && varies(field); });
}

void add_position_fields(NeutralMesh& mesh) {
  const std::vector<std::array<std::uint64_t, 3>> boundary = boundary_of(mesh);
  const std::size_t cut = cut_cells_between_boundaries(mesh, boundary);
  std::vector<NeutralField> fields;
  if (!boundary.empty()) {
    NeutralField distance;
    distance.name = formats::boundary_distance;
    distance.unit = mesh.length_unit;
    distance.values = distances_to(boundary, mesh.points);
    NeutralField interior;
    interior.name = "interior";
    for (const double value : distance.values) interior.values.push_back(value > 0 ? 1 : 0);
    fields.push_back(std::move(distance));
    fields.push_back(std::move(interior));
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
  mesh.notes.push_back(boundary.empty() ? "no field varies; added the coordinates x, y and z"
                                        : "no field varies; added boundary_distance (distance of each point to the "
                                          "mesh's boundary), interior (0 at the boundary, 1 inside), x, y and z");
  if (cut > 0)
    mesh.notes.push_back(
        concat(count_text(cut, "tetrahedron", "tetrahedra"),
               " with all corners on the boundary split in four, so that boundary_distance is above 0 inside"));
}

void give_fields(NeutralMesh& mesh, bool& cells_to_points) {
  if (!has_varying_field(mesh)) return add_position_fields(mesh);
  if (!mesh.point_fields.empty() || cells_to_points) return;
  cells_to_points = true;
  mesh.notes.push_back("no point data; cell data were averaged to the points");
}

}  // namespace rhoray::preprocess
