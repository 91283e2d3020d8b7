#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/mesh/subdivide/curved_cell.h"
#include "preprocess/mesh/subdivide/cut_cell.h"
#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// A tetrahedron over corners of a curved cell.
struct CornerTetrahedronOfCell {
  std::uint32_t curved_cell;  ///< position among the curved cells
  CornerTetrahedron corners;
};

/// How far the curved cells and the tetrahedra that stand for them lie apart at most: 1.5 times what is found at
/// several places on every edge, and what is found at the middles of all faces and tetrahedra. For quadratic tetrahedra
/// that is a bound, for other kinds a sample.
struct RefinementError {
  double geometric = 0;           ///< as a share of the box diagonal of all points of cells
  std::vector<double> of_fields;  ///< as a share of the range of each point field; 0 of one that does not count
};

struct RefineOptions {
  double max_error;           ///< in shares, as in RefinementError
  std::vector<bool> counted;  ///< for each point field whether its error counts
  double finest;              ///< share of a cell: an edge that stretches over less is cut for neighbours only
};

struct RefinedCells {
  Array<std::array<std::uint64_t, 4>> tets;  ///< by curved cell, in their order
  Array<std::uint32_t> curved_cells;         ///< of each
  RefinementError error;
  std::uint64_t cut_cells = 0;  ///< curved cells that are more tetrahedra than their corners need
  /// How many tetrahedra were cut since they strayed too far, by what strayed farthest: the place, then each field.
  std::vector<std::uint64_t> cut_for;
};

/// Cuts the tetrahedra in two until they follow the curved cells. New points, with their values of every point field,
/// are added at the end of the mesh's; some may be used by no tetrahedron. Nodes of cells become points of the
/// result where an edge is cut at them.
///
/// A tetrahedron is always cut at its longest edge (of equal ones by ids), whatever asks for it: that it strays too far
/// from its cell, or that one of its edges is cut for a neighbour's sake. A triangle between two of them is then cut
/// at its own longest edge from both sides, and at the end no edge of a tetrahedron is cut: faces agree (Rivara 1984,
/// "Algorithms for refining triangular grids").
///
/// Runs on all threads; the result does not depend on the number of threads. Refuses (ErrorCode::resource) more than
/// 2^32 - 1 points or tetrahedra, and more new ones than 2^19 and 4096 for each curved cell.
RefinedCells refine(CellMesh& mesh, std::span<const CurvedCell> cells, std::span<const CornerTetrahedronOfCell> tets,
                    const RefineOptions& options, const Progress& progress);

}  // namespace rhoray::preprocess
