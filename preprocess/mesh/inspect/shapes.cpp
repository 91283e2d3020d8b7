#include <array>
#include <cmath>

#include "formats/base/parallel.h"
#include "preprocess/mesh/inspect/finding.h"
#include "preprocess/mesh/inspect/orientation.h"

namespace rhoray::preprocess::inspect {
namespace {

constexpr double sliver_quality = 0.01;

bool names_a_vertex_twice(const std::array<std::uint64_t, 4>& cell) {
  return cell[0] == cell[1] || cell[0] == cell[2] || cell[0] == cell[3] || cell[1] == cell[2] || cell[1] == cell[3] ||
         cell[2] == cell[3];
}

/// 3 r / R of the inscribed and the circumscribed sphere: 1 for a regular tetrahedron, 0 for a flat
/// one.
double radius_ratio(const NeutralMesh& mesh, const std::array<std::uint64_t, 4>& cell) {
  std::array<Vec3, 4> p;
  for (std::size_t v = 0; v < 4; ++v) {
    const auto& point = mesh.points[cell[v]];
    p[v] = Vec3(point[0], point[1], point[2]);
  }
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], w = p[3] - p[0];
  const double six_volumes = std::abs(u.cross(v).dot(w));
  const double twice_surface =
      u.cross(v).length() + v.cross(w).length() + w.cross(u).length() + (v - u).cross(w - u).length();
  // R = area / (6 V) of the triangle whose sides are the products of opposite edges (Crelle).
  const double a = u.length() * (w - v).length(), b = v.length() * (w - u).length(), c = w.length() * (v - u).length();
  const double s = (a + b + c) / 2, area = std::sqrt(std::max(0.0, s * (s - a) * (s - b) * (s - c)));
  return area == 0 ? 0 : 3 * (six_volumes / twice_surface) * (six_volumes / area);
}

enum class Shape : std::uint8_t { good, repeating, not_finite, flat, sliver };
struct Seen {
  Shape shape = Shape::good;
  bool flipped = false;
};

Seen look_at(const NeutralMesh& mesh, std::size_t c) {
  const auto& cell = mesh.cells[c];
  if (names_a_vertex_twice(cell)) return {.shape = Shape::repeating};
  if (!is_traceable(mesh, c)) return {.shape = Shape::not_finite};
  const int sign = orientation(mesh.points[cell[0]], mesh.points[cell[1]], mesh.points[cell[2]], mesh.points[cell[3]]);
  if (sign == 0) return {.shape = Shape::flat};
  return {.shape = radius_ratio(mesh, cell) < sliver_quality ? Shape::sliver : Shape::good, .flipped = sign < 0};
}

}  // namespace

bool is_traceable(const NeutralMesh& mesh, std::size_t c) {
  const auto& cell = mesh.cells[c];
  return !names_a_vertex_twice(cell) && std::all_of(cell.begin(), cell.end(), [&](std::uint64_t vertex) {
    const auto& p = mesh.points[vertex];
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
  });
}

void shapes(const NeutralMesh& mesh, Findings& findings) {
  std::vector<Seen> seen(mesh.cells.size());
  parallel_for(seen.size(), 1024, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) seen[c] = look_at(mesh, c);
  });
  Tally repeating, flat, flipped, slivers;
  for (std::size_t c = 0; c < seen.size(); ++c) {
    const std::uint64_t id = id_of_cell(mesh, c);
    if (seen[c].shape == Shape::repeating) repeating.add(id);
    if (seen[c].shape == Shape::flat) flat.add(id);
    if (seen[c].shape == Shape::sliver) slivers.add(id);
    if (seen[c].flipped) flipped.add(id);
  }
  findings.push_back(std::move(repeating).finding("cells with a vertex twice", "cell", "dropped"));
  findings.push_back(std::move(flat).finding("flat cells", "cell", "kept: they carry the surface from face to face"));
  findings.push_back(std::move(flipped).finding("flipped cells", "cell", "turned: two vertices are exchanged"));
  findings.push_back(std::move(slivers).finding("slivers", "cell", "kept as they are"));
}

}  // namespace rhoray::preprocess::inspect
