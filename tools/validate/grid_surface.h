#pragma once

#include <vector>

#include "tools/validate/geometry.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools::validate {

/// Points where the field takes the isovalue on edges of the grid, where it is linear: a random choice of them.
struct EdgePoints {
  std::vector<Vec3> points_index;
  std::uint64_t edge_count = 0;  ///< of all edges with such a point
  std::uint64_t cell_count = 0;  ///< of all cells with corners on both sides
};
EdgePoints edge_points(const GridField& field, double isovalue, std::size_t most, std::uint64_t seed);

struct SurfaceSpec {
  double facet_count = 40'000;  ///< about so many
  std::uint64_t most_evaluations = 400'000'000;
  bool measures_offsets = true;  ///< false: GridSurface::offsets stays empty
};

/// The isosurface of a trilinear field as CGAL's surface mesher finds it: vertices lie on it up to 1e-9 of the grid,
/// triangles near it. It starts from points on the grid's edges, spread over all parts of the surface; parts smaller
/// than a triangle may be lost. Not promised: the same triangles every time; the mesher goes by where things lie in
/// memory.
struct GridSurface {
  Triangles triangles;          ///< in the grid's frame; those with their centre in the data
  std::vector<double> offsets;  ///< of the triangles: the largest distance from the isosurface along the normal that
                                ///< was measured, at the centre and three points around it, in cells; NaN: none found
  double triangle_radius = 0;   ///< wished, in cells
  bool is_complete = true;      ///< false when the mesher ran out of evaluations
};
GridSurface mesh_surface(const GridField& field, double isovalue, const EdgePoints& seeds, const SurfaceSpec& spec);

/// How far along `direction` (of unit length, either way) the isosurface lies from a point, up to `farthest`; all in
/// the frame "index". NaN when it is not met.
double offset_along(const GridField& field, double isovalue, const Vec3& p_index, const Vec3& direction,
                    double farthest);

}  // namespace rhoray::tools::validate
