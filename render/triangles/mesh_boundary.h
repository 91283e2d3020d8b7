#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/tets/tet_data.h"

namespace rhoray::render {

/// The boundary of a mesh as triangles, in the mesh's frame: the faces that belong to one cell only
/// (formats/mesh_boundary.h). Corners are counter-clockwise seen from outside the triangle's cell.
struct MeshBoundary {
  /// Refuses a boundary of 2^32 faces or more (ErrorCode::unsupported).
  explicit MeshBoundary(const TetData& of);

  TetData mesh;
  std::vector<std::array<double, 3>> points;            ///< of the mesh that are corners
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of these points
  std::vector<std::uint32_t> cells;                     ///< of each triangle
};

}  // namespace rhoray::render
