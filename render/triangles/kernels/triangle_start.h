#pragma once

#include <array>
#include <cmath>

#include "render/traverse/ray.h"

namespace rhoray::render {

/// Distance from a triangle's plane up to which a ray is taken to start in it, in the frame of
/// facets (render/triangles/facets.h): larger than the error of a start in single precision.
inline constexpr double start_distance = 0x1p-18;

/// True when a ray with a known start side starts in a triangle's plane and does not approach it
/// from the other side. The ray then starts on that triangle or on a neighbour. Triangles may have
/// any orientation, so those farther away may be hit from either side. A triangle without area is
/// always considered left.
/// @param corner    of the triangle
/// @param normal    of any length
/// @param distance  up to which a start counts as in the plane, in the ray's frame
RHORAY_INLINE bool starts_in(const Ray& ray, const std::array<double, 3>& corner, const Vec3& normal, double distance) {
  const Vec3 start = ray.at(ray.t_min) - Vec3(corner[0], corner[1], corner[2]);
  const double away = normal.dot(start) / normal.length();
  const double rise = normal.dot(ray.direction) * static_cast<double>(ray.start_side);
  // Written so that a triangle without a normal counts.
  return !(std::abs(away) > distance) && !(rise < 0);
}

}  // namespace rhoray::render
