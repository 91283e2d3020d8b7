#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "formats/base/vector.h"
#include "preprocess/mesh/inspect/finding.h"
#include "preprocess/mesh/inspect/orientation.h"
#include "preprocess/mesh/inspect/point_tree.h"

namespace rhoray::preprocess::inspect {
namespace {

/// A face that belongs to one cell alone. Its vertices run counter-clockwise seen from outside.
struct BoundaryFace {
  std::array<std::uint64_t, 3> vertices;
  std::uint64_t cell;
};

std::vector<BoundaryFace> boundary_faces(const NeutralMesh& mesh, const std::vector<CellFace>& faces) {
  std::vector<BoundaryFace> result;
  for (std::size_t begin = 0, end; begin < faces.size(); begin = end) {
    for (end = begin + 1; end < faces.size() && faces[end].vertices == faces[begin].vertices;) ++end;
    if (end - begin != 1) continue;
    const CellFace& face = faces[begin];
    BoundaryFace found{.vertices = face.vertices, .cell = face.cell};
    const auto& v = found.vertices;
    if (orientation(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]],
                    mesh.points[mesh.cells[face.cell][face.corner]]) > 0)
      std::swap(found.vertices[1], found.vertices[2]);  // the cell lies behind its face
    result.push_back(found);
  }
  return result;
}

Vec3 place(const NeutralMesh& mesh, std::uint64_t point) {
  return {mesh.points[point][0], mesh.points[point][1], mesh.points[point][2]};
}

/// Disjoint sets that are joined in pairs.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[std::max(root(a), root(b))] = std::min(root(a), root(b)); }

 private:
  std::vector<std::size_t> parent_;
};

struct TransparentSurfaces {
  Tally pinched;   ///< edges where more than two faces of the boundary meet
  Tally cavities;  ///< closed boundary surfaces that enclose no cells
  std::uint64_t count = 0;
};

/// Finds the boundary's surfaces: sets of boundary faces joined over edges. A surface that encloses
/// empty space has a negative volume.
TransparentSurfaces transparent_surfaces_of(const NeutralMesh& mesh, const std::vector<BoundaryFace>& faces) {
  struct Edge {
    std::array<std::uint64_t, 2> ends;
    std::size_t face;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t v = 0; v < 3; ++v) {
      const auto [a, b] = std::minmax(faces[f].vertices[v], faces[f].vertices[(v + 1) % 3]);
      edges.push_back({{a, b}, f});
    }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.ends != b.ends ? a.ends < b.ends : a.face < b.face; });
  TransparentSurfaces shells;
  Sets sets(faces.size());
  for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
    for (end = begin + 1; end < edges.size() && edges[end].ends == edges[begin].ends;) ++end;
    if (end - begin > 2) shells.pinched.add(id_of_cell(mesh, faces[edges[begin].face].cell));
    for (std::size_t e = begin + 1; e < end; ++e) sets.join(edges[begin].face, edges[e].face);
  }
  if (faces.empty()) return shells;
  const Vec3 origin = place(mesh, faces.front().vertices[0]);
  std::map<std::size_t, double> volumes;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& v = faces[f].vertices;
    const Vec3 a = place(mesh, v[0]) - origin, b = place(mesh, v[1]) - origin, c = place(mesh, v[2]) - origin;
    volumes[sets.root(f)] += a.cross(b).dot(c) / 6;
  }
  shells.count = volumes.size();
  for (const auto& [root, volume] : volumes)
    if (volume < 0) shells.cavities.add(id_of_cell(mesh, faces[root].cell));
  return shells;
}

/// Returns the points that the boundary names, each once.
PointTree points_of(const NeutralMesh& mesh, const std::vector<BoundaryFace>& faces) {
  std::vector<std::uint64_t> points;
  for (const BoundaryFace& face : faces) points.insert(points.end(), face.vertices.begin(), face.vertices.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<PointTree::Point> named;
  for (const std::uint64_t point : points) named.push_back({place(mesh, point), point});
  return PointTree(std::move(named));
}

/// True when p lies in the triangle within `tolerance`: edges count, corners do not.
bool lies_in(const Vec3& p, const std::array<Vec3, 3>& triangle, double tolerance) {
  for (const Vec3& corner : triangle)
    if ((p - corner).length() <= tolerance) return false;
  const Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
  const double length = normal.length();
  if (length == 0 || std::abs(normal.dot(p - triangle[0])) > tolerance * length) return false;
  for (std::size_t v = 0; v < 3; ++v) {
    const Vec3 edge = triangle[(v + 1) % 3] - triangle[v];
    if (normal.cross(edge).dot(p - triangle[v]) < -tolerance * edge.length() * length) return false;
  }
  return true;
}

Finding hanging_points(const NeutralMesh& mesh, const std::vector<BoundaryFace>& faces) {
  constexpr double relative_tolerance = 1e-6;
  const PointTree tree = points_of(mesh, faces);
  Tally tally;
  for (const BoundaryFace& face : faces) {
    const std::array<Vec3, 3> corners{place(mesh, face.vertices[0]), place(mesh, face.vertices[1]),
                                      place(mesh, face.vertices[2])};
    double longest = 0;
    Box3 box;
    for (std::size_t v = 0; v < 3; ++v) {
      longest = std::max(longest, (corners[(v + 1) % 3] - corners[v]).length());
      box.extendBy(corners[v]);
    }
    const double tolerance = relative_tolerance * longest;
    const Vec3 reach(tolerance, tolerance, tolerance);
    bool found = false;
    tree.for_each_in(Box3(box.min - reach, box.max + reach), [&](std::uint64_t point) {
      found = found || (std::find(face.vertices.begin(), face.vertices.end(), point) == face.vertices.end() &&
                        lies_in(place(mesh, point), corners, tolerance));
    });
    if (found) tally.add(id_of_cell(mesh, face.cell));
  }
  return std::move(tally).finding("faces in which a point of another cell hangs", "cell",
                                  "kept: the field may jump there, and the surface with it");
}

}  // namespace

void boundary(const NeutralMesh& mesh, const std::vector<CellFace>& cell_faces, Findings& findings) {
  const std::vector<BoundaryFace> faces = boundary_faces(mesh, cell_faces);
  TransparentSurfaces shells = transparent_surfaces_of(mesh, faces);
  findings.push_back(hanging_points(mesh, faces));
  findings.push_back(std::move(shells.pinched)
                         .finding("edges where the boundary touches itself", "cell", "kept: it does no harm to rays"));
  findings.push_back(std::move(shells.cavities).finding("cavities", "cell", "kept: nothing is traced inside them"));
}

}  // namespace rhoray::preprocess::inspect
