#include "preprocess/export_tets.h"

#include <algorithm>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/nearest_name.h"
#include "formats/base/pending_file.h"
#include "formats/mesh_boundary.h"
#include "formats/tet_mesh.h"
#include "preprocess/export/lost_facts.h"
#include "preprocess/export/stl_file.h"
#include "preprocess/import_mesh.h"
#include "preprocess/unpack_mesh.h"

namespace rhoray::preprocess {
namespace {

using formats::TetMesh;

Vec3 world_point(const TetMesh& mesh, std::uint32_t point) {
  const auto& p = mesh.points()[point];
  return mesh.description().origin + Vec3(p[0], p[1], p[2]);
}

std::size_t field_position(const TetMesh& mesh, const std::string& field) {
  if (field.empty()) return 0;
  if (const auto found = mesh.find_field(field)) return *found;
  std::vector<std::string> names;
  std::string known;
  for (const formats::FieldSummary& summary : mesh.description().fields) {
    names.push_back(summary.name);
    known += concat(known.empty() ? "'" : ", '", summary.name, "'");
  }
  throw Error(ErrorCode::usage, concat(mesh.file().name(), ": no field '", field, "'; it has ", known),
              did_you_mean(field, names));
}

/// Calls act(span of floats or doubles) with a field's values.
template <class Act>
void with_values(const TetMesh& mesh, std::size_t field, Act&& act) {
  if (mesh.description().fields[field].type == formats::ElementType::F32)
    act(mesh.values<float>(field));
  else
    act(mesh.values<double>(field));
}

/// The point on an edge, from a corner inside to one outside, where the field takes the isovalue.
Vec3 crossing(const Vec3& from, const Vec3& to, double value_from, double value_to, double isovalue) {
  const double share = (isovalue - value_from) / (value_to - value_from);
  return (1 - share) * from + share * to;
}

/// One tetrahedron's part of the isosurface: a triangle, or a quadrilateral cut into two.
void add_isosurface(StlFile& file, const std::array<Vec3, 4>& points, const std::array<double, 4>& values,
                    double isovalue) {
  std::size_t inside[4], outside[4], in_count = 0, out_count = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    if (!std::isfinite(values[v])) return;
    if (values[v] >= isovalue)
      inside[in_count++] = v;
    else
      outside[out_count++] = v;
  }
  if (in_count == 0 || out_count == 0) return;
  const auto cut = [&](std::size_t i, std::size_t o) {
    return crossing(points[inside[i]], points[outside[o]], values[inside[i]], values[outside[o]], isovalue);
  };
  // Fronts face away from the corner with the higher value.
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    if ((b - a).cross(c - a).dot(a - points[inside[0]]) >= 0)
      file.add(a, b, c);
    else
      file.add(a, c, b);
  };
  if (in_count == 1) return add(cut(0, 0), cut(0, 1), cut(0, 2));
  if (in_count == 3) return add(cut(0, 0), cut(1, 0), cut(2, 0));
  add(cut(0, 0), cut(0, 1), cut(1, 1));
  add(cut(0, 0), cut(1, 1), cut(1, 0));
}

void write_isosurface(StlFile& file, const TetMesh& mesh, std::size_t field, double isovalue) {
  with_values(mesh, field, [&](const auto values) {
    for (std::uint64_t c = 0; c < mesh.description().cell_count; ++c) {
      const auto cell = mesh.cell(c);
      std::array<Vec3, 4> points;
      std::array<double, 4> at;
      for (std::size_t v = 0; v < 4; ++v) {
        points[v] = world_point(mesh, cell[v]);
        at[v] = static_cast<double>(values[cell[v]]);
      }
      add_isosurface(file, points, at, isovalue);
    }
  });
}

void write_boundary(StlFile& file, const TetMesh& mesh) {
  for (const std::uint64_t number : formats::boundary_faces(mesh)) {
    const auto [cell, opposite] = formats::face_of_number(number);
    const auto [a, b, c] = formats::face_points(mesh.cell(cell), opposite);
    file.add(world_point(mesh, a), world_point(mesh, b), world_point(mesh, c));
  }
}

}  // namespace

ExportReport export_vtu(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options) {
  const TetMesh tets(open_packed(packed, options.source_name));
  NeutralMesh mesh = unpack_mesh(tets);
  NeutralField ids{.name = "cell_id", .unit = {}, .component_count = 1, .was_single_precision = false, .values = {}};
  ids.values.assign(mesh.cell_ids.begin(), mesh.cell_ids.end());
  mesh.cell_fields.push_back(std::move(ids));
  export_mesh(mesh, output, options.replace_existing);
  ExportReport report;
  report.file_bytes = std::filesystem::file_size(output);
  note_lost_facts(tets.description(), vtu_facts, report.notes);
  return report;
}

ExportReport export_tets_stl(const std::filesystem::path& packed, std::optional<double> isovalue,
                             const std::filesystem::path& output, const ExportOptions& options) {
  const DefaultFloatingPoint default_floating_point;
  if (isovalue && !std::isfinite(*isovalue))
    throw Error(ErrorCode::usage, concat("isovalue ", *isovalue, "; expected a finite number"));
  const TetMesh mesh(open_packed(packed, options.source_name));
  const std::size_t field = field_position(mesh, options.field);
  PendingFile pending(output, {.replace_existing = options.replace_existing});
  StlFile file(pending.open_name(), output.string());
  if (isovalue)
    write_isosurface(file, mesh, field, *isovalue);
  else
    write_boundary(file, mesh);
  ExportReport report;
  const StlCounts triangles = file.finish();
  pending.publish();
  report.triangle_count = triangles.written;
  report.file_bytes = std::filesystem::file_size(output);
  note_vanished(triangles, report.notes);
  note_lost_facts(mesh.description(), stl_facts, report.notes);
  return report;
}

}  // namespace rhoray::preprocess
