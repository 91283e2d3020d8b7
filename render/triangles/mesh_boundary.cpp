#include "render/triangles/mesh_boundary.h"

#include <limits>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "formats/mesh_boundary.h"

namespace rhoray::render {

MeshBoundary::MeshBoundary(const TetData& of) : mesh(of) {
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  const formats::FaceNumbers faces = formats::boundary_faces(mesh.mesh());
  if (faces.size() >= none)
    throw Error(ErrorCode::unsupported, concat(mesh.mesh().file().name(), ": a boundary of ", faces.size(),
                                               " faces; expected fewer than ", none));
  std::vector<std::uint32_t> place(mesh.points().size(), none);
  triangles.reserve(faces.size()), cells.reserve(faces.size());
  for (const std::uint64_t number : faces) {
    const auto [cell, opposite] = formats::face_of_number(number);
    cells.push_back(static_cast<std::uint32_t>(cell));
    std::array<std::uint32_t, 3> corners = formats::face_points(mesh.vertices(cells.back()), opposite);
    for (std::uint32_t& corner : corners) {
      if (place[corner] == none) {
        place[corner] = static_cast<std::uint32_t>(points.size());
        points.push_back(mesh.points()[corner]);
      }
      corner = place[corner];
    }
    triangles.push_back(corners);
  }
}

}  // namespace rhoray::render
