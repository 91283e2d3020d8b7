#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/progress.h"
#include "preprocess/mesh/subdivide/curved_cell.h"
#include "preprocess/mesh/subdivide/cut_cell.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A tetrahedron over corners of a curved cell.
struct CornerTetrahedronOfCell {
  std::uint32_t curved_cell;  ///< index among the curved cells
  CornerTetrahedron corners;
};

/// Largest distance between the curved cells and their tetrahedra. It is the maximum of two values:
/// 1.5 times the distance at several points of every edge, and the distance at the centres of all
/// faces and tetrahedra. For quadratic tetrahedra it is a bound, for other kinds a sample.
struct RefinementError {
  double geometric = 0;  ///< as a fraction of the box diagonal of all points of cells
  /// as a fraction of the range of each point field; 0 for a field that does not count
  std::vector<double> of_fields;
};

struct RefineOptions {
  double max_error;           ///< relative, as in RefinementError
  std::vector<bool> counted;  ///< for each point field whether its error counts
  /// fraction of a cell: an edge that spans less is cut for neighbours only
  double finest;
};

struct RefinedCells {
  Array<std::array<std::uint64_t, 4>> tets;  ///< by curved cell, in their order
  Array<std::uint32_t> curved_cells;         ///< of each
  RefinementError error;
  std::uint64_t cut_cells = 0;  ///< curved cells cut into more tetrahedra than their corners need
  /// Number of tetrahedra cut because their error was too large, by the error that was largest: the
  /// geometric one, then each field.
  std::vector<std::uint64_t> cut_for;
};

/// Bisects the tetrahedra until they follow the curved cells. New points, with their values of
/// every point field, are added at the end of the mesh's points; some may be used by no
/// tetrahedron. A node of a cell becomes a point of the result where an edge is cut at it.
///
/// A tetrahedron is always cut at its longest edge (ties are broken by ids). This holds whether its
/// error is too large or one of its edges is cut for a neighbour. A triangle between two tetrahedra
/// is then cut at its own longest edge from both sides. At the end, no edge of a tetrahedron is
/// cut, so faces agree (Rivara 1984, "Algorithms for refining triangular grids").
///
/// Runs on all threads; the result does not depend on the number of threads. Refuses with
/// ErrorCode::resource: more than 2^32 - 1 points or tetrahedra, and more new ones than 2^19 and
/// 4096 for each curved cell.
RefinedCells refine(CellMesh& mesh, std::span<const CurvedCell> cells, std::span<const CornerTetrahedronOfCell> tets,
                    const RefineOptions& options, const Progress& progress);

}  // namespace rhoray::preprocess
