#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// A closed surface around a point that sees all of it.
struct StarSurface {
  std::function<double(const Vec3&)> outside_by;  ///< negative inside, positive outside
  Vec3 centre;
  double reach = 0;  ///< every point of the surface is closer to the centre
};

/// The point of the surface in this direction, to about 1e-9 of the reach.
Vec3 surface_point(const StarSurface& surface, const Vec3& direction);

struct Triangulation {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// Triangles with corners on the surface whose edges are about as long as `edge_length` asks for at
/// their middles: none was longer before the last smoothing. Seen from the centre they cover the
/// sphere once, so they never cross.
Triangulation triangulate(const StarSurface& surface, const std::function<double(const Vec3&)>& edge_length);

}  // namespace rhoray::recipes
