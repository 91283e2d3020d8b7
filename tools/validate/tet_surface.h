#pragma once

#include <vector>

#include "tools/validate/geometry.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// The isosurface of a field on tetrahedra: a triangle, or a quadrilateral cut in two, in each cell
/// with points on both sides. Corners lie on edges where the exact linear interpolation of the
/// stored doubles (CGAL's exact constructions) equals the isovalue. Each corner is rounded once,
/// and is one point for all cells at its edge, so that the triangles leave no gaps.
struct TetSurface {
  Triangles triangles;
  std::vector<std::uint32_t> cells;       ///< of the triangles
  std::vector<std::uint32_t> straddling;  ///< all cells with points on both sides
};
TetSurface extract_surface(const TetField& field, double isovalue);

}  // namespace rhoray::tools::validate
