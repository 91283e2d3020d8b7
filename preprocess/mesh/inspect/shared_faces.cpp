#include <algorithm>
#include <array>

#include "formats/base/parallel.h"
#include "preprocess/mesh/inspect/finding.h"
#include "preprocess/mesh/inspect/orientation.h"

namespace rhoray::preprocess::inspect {
namespace {

/// The side of the face, its vertices in ascending order, on which the cell lies.
int side_of(const NeutralMesh& mesh, const CellFace& face) {
  const auto& v = face.vertices;
  return orientation(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]],
                     mesh.points[mesh.cells[face.cell][face.corner]]);
}

}  // namespace

std::vector<CellFace> sorted_faces(const NeutralMesh& mesh) {
  std::vector<CellFace> faces;
  faces.reserve(4 * mesh.cells.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (!is_traceable(mesh, c)) continue;
    for (std::uint8_t corner = 0; corner < 4; ++corner) {
      CellFace face{.vertices = {}, .cell = c, .corner = corner};
      for (std::size_t v = 0, to = 0; v < 4; ++v)
        if (v != corner) face.vertices[to++] = mesh.cells[c][v];
      std::sort(face.vertices.begin(), face.vertices.end());
      faces.push_back(face);
    }
  }
  parallel_sort(std::span(faces), [](const CellFace& a, const CellFace& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.cell < b.cell;
  });
  return faces;
}

void shared_faces(const NeutralMesh& mesh, const std::vector<CellFace>& faces, Findings& findings) {
  Tally by_too_many, from_one_side;
  for (std::size_t begin = 0, end; begin < faces.size(); begin = end) {
    for (end = begin + 1; end < faces.size() && faces[end].vertices == faces[begin].vertices;) ++end;
    if (end - begin > 2) by_too_many.add(id_of_cell(mesh, faces[begin].cell));
    if (end - begin != 2) continue;
    const int a = side_of(mesh, faces[begin]), b = side_of(mesh, faces[begin + 1]);
    if (a == b && a != 0) from_one_side.add(id_of_cell(mesh, faces[begin].cell));
  }
  findings.push_back(
      std::move(by_too_many)
          .finding("faces shared by more than two cells", "cell", "kept: the surface may be met more than once there"));
  findings.push_back(std::move(from_one_side)
                         .finding("faces with both cells on one side", "cell",
                                  "kept: the cells overlap, and the one met first is shown"));
}

}  // namespace rhoray::preprocess::inspect
