#pragma once

#include <array>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "formats/base/progress.h"

namespace rhoray::formats {

class TetMesh;

/// A face of a mesh: number 4 c + k is the face of cell c opposite the cell's vertex k.
struct CellFace {
  std::uint64_t cell;
  unsigned opposite;
};
constexpr std::uint64_t face_number(const CellFace& face) {
  return 4 * face.cell + face.opposite;
}
constexpr CellFace face_of_number(std::uint64_t number) {
  return {number / 4, static_cast<unsigned>(number % 4)};
}

/// The points of a face, counter-clockwise seen from outside a cell of positive orientation
/// (tet_mesh.h).
constexpr std::array<std::uint32_t, 3> face_points(const std::array<std::uint32_t, 4>& cell, unsigned opposite) {
  constexpr std::uint8_t corners[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  return {cell[corners[opposite][0]], cell[corners[opposite][1]], cell[corners[opposite][2]]};
}

/// Faces that are compared at a time, with 16 bytes each.
inline constexpr std::uint64_t most_faces_at_once = std::uint64_t{1} << 24;

/// Grows with the mesh, so the default memory resource decides where it is stored.
using FaceNumbers = std::pmr::vector<std::uint64_t>;

/// The numbers of the faces that belong to one cell only, ascending. Together they are the boundary
/// of the mesh. Faces are the same where their points have the same indices.
/// @param cells         point indices, below point_count
/// @param most_at_once  faces that are compared at a time
FaceNumbers boundary_faces(std::span<const std::array<std::uint32_t, 4>> cells, std::uint64_t point_count,
                           std::uint64_t most_at_once = most_faces_at_once, const Watch& watch = {});

/// The same for a packed mesh: the stored boundary, or else the computed one.
FaceNumbers boundary_faces(const TetMesh& mesh, const Watch& watch = {});

/// The boundary of a part of a packed mesh: the numbers of the faces that belong to one cell of the
/// part only, ascending. On the other side of each is no cell, or one outside the part.
/// @param part  indices of cells, all different
FaceNumbers boundary_faces(const TetMesh& mesh, std::span<const std::uint64_t> part, const Watch& watch = {});

/// The boundary, computed from the cells even where it is stored.
FaceNumbers computed_boundary_faces(const TetMesh& mesh, const Watch& watch = {});

}  // namespace rhoray::formats
