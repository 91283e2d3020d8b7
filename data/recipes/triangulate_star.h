#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// A closed surface around a point from which all of it is visible.
struct StarSurface {
  std::function<double(const Vec3&)> outside_by;  ///< negative inside, positive outside
  Vec3 centre;
  double reach = 0;  ///< radius around the centre that contains the surface
};

/// The surface point in this direction, accurate to about 1e-9 of the reach.
Vec3 surface_point(const StarSurface& surface, const Vec3& direction);

struct Triangulation {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// Triangulates the surface. Edges are about as long as `edge_length` requests at their midpoints;
/// before the last smoothing none was longer. Seen from the centre, the triangles cover the sphere
/// once, so they never cross.
Triangulation triangulate(const StarSurface& surface, const std::function<double(const Vec3&)>& edge_length);

}  // namespace rhoray::recipes
