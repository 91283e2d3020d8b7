#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/progress.h"
#include "formats/mesh_boundary.h"
#include "render/tets/tet_data.h"

namespace rhoray::render {

/// The boundary of a mesh, or of its cells with one label, as triangles in the mesh's frame: the
/// faces that belong to one cell only (formats/mesh_boundary.h). Corners are counter-clockwise seen
/// from outside the triangle's cell.
///
/// A face between two labels is a triangle of both boundaries. Both have its points in the same
/// order of indices and start with the same corner, so kernels compute the same t for both.
struct MeshBoundary {
  /// Refuses a boundary of 2^32 faces or more (ErrorCode::unsupported).
  explicit MeshBoundary(const TetData& of, const Watch& watch = {});
  /// The boundary of the cells that have a label in a cell field; without triangles if there are no
  /// such cells. See Dataset::boundary.
  MeshBoundary(const TetData& of, std::size_t cell_field, int label, std::span<const int> without,
               const Watch& watch = {});

  TetData mesh;
  std::vector<std::array<double, 3>> points;            ///< of the mesh that are corners; in its order
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of these points; the lowest first
  std::vector<std::uint32_t> cells;                     ///< of each triangle

 private:
  MeshBoundary(const TetData& of, const formats::FaceNumbers& faces, const Watch& watch);
};

}  // namespace rhoray::render
