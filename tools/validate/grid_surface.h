#pragma once

#include <string_view>
#include <vector>

#include "tools/validate/geometry.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools::validate {

/// A random selection of the points where the field equals the isovalue on edges of the grid. It is
/// linear there.
struct EdgePoints {
  std::vector<Vec3> points_index;
  std::uint64_t edge_count = 0;  ///< all edges with such a point
  std::uint64_t cell_count = 0;  ///< all cells with corners on both sides
};
EdgePoints edge_points(const GridField& field, double isovalue, std::size_t most, std::uint64_t seed);

struct SurfaceSpec {
  double facet_count = 40'000;  ///< approximate number
  std::uint64_t most_evaluations = 400'000'000;
  bool measures_offsets = true;  ///< false: GridSurface::offsets stays empty
};

/// The isosurface of a trilinear field from CGAL's surface mesher. Its vertices lie on the
/// isosurface up to 1e-9 of the grid, its triangles near it. The mesher starts from points on the
/// grid's edges, spread over all parts of the surface. Parts smaller than a triangle may be lost.
/// It does not promise the same triangles every time, because the mesher depends on memory
/// addresses.
struct GridSurface {
  Triangles triangles;  ///< in the grid's frame; only those with their centre inside the data
  /// For each triangle: the largest measured distance from the isosurface along the normal, at the
  /// centre and three points around it, in cells; NaN: none found.
  std::vector<double> offsets;
  double triangle_radius = 0;        ///< requested, in cells
  std::string_view stopped_because;  ///< why the mesher ended too early; empty: it did not
};
GridSurface mesh_surface(const GridField& field, double isovalue, const EdgePoints& seeds, const SurfaceSpec& spec);

/// Distance of the isosurface from a point along `direction` (unit length, either way), up to
/// `farthest`. All in the frame "index". NaN if it is not reached.
double offset_along(const GridField& field, double isovalue, const Vec3& p_index, const Vec3& direction,
                    double farthest);

}  // namespace rhoray::tools::validate
