#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/vector.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Cells and points that may be packed, and notes on the problems of the others.
struct CleanMesh {
  Vec3 origin;                          ///< source point = origin + point, exactly
  Array<std::array<double, 3>> points;  ///< relative to origin; each belongs to a cell
  /// in the source's order, none of negative orientation
  Array<std::array<std::uint32_t, 4>> cells;
  Array<std::uint64_t> source_points;  ///< index of each point in NeutralMesh::points
  Array<std::uint64_t> source_cells;   ///< index of each cell in NeutralMesh::cells
  Box3 box;                            ///< of the points; has a volume
  std::uint64_t flipped_cell_count = 0;
  std::uint64_t flat_cell_count = 0;
  std::uint64_t dropped_cell_count = 0;
  std::uint64_t unused_point_count = 0;
  /// one sentence for each kind of problem, with its count and first positions
  std::vector<std::string> notes;
};

/// Drops cells that name a vertex twice or have a coordinate that is not finite, and then points
/// without a cell. Inverts negatively oriented cells by exchanging their last two vertices. Keeps
/// cells of zero volume. Orientation is exact.
///
/// The origin is zero on an axis where the mesh lies around zero, else near the middle of its box.
/// Either way the subtraction is exact, and orientations are those of the source's own coordinates.
///
/// Refuses with ErrorCode::invalid, with cell or point and number: a mesh without cells, a vertex
/// index out of range, a coordinate beyond 1e100, and a box without volume. Refuses with
/// ErrorCode::unsupported: 2^32 cells or points.
CleanMesh clean_mesh(const NeutralMesh& mesh, const std::string& source_name);

}  // namespace rhoray::preprocess
