#pragma once

#include <array>
#include <cmath>

#include "render/traverse/ray.h"

namespace rhoray::render {

/// How near to a triangle's plane a ray is taken to start in it, in the frame of facets (volumes/facets.h): farther
/// than single precision moves a start.
inline constexpr double start_distance = 0x1p-18;

/// Whether a ray of a known side starts in a triangle's plane and does not come to it from the other side: it is that
/// triangle, or a neighbour, that the ray leaves. Triangles may face any way, so that those farther away are met from
/// either side. A triangle without area is left by all.
/// @param corner    of the triangle
/// @param normal    of any length
/// @param distance  that still counts as in the plane, in the ray's frame
RHORAY_INLINE bool starts_in(const Ray& ray, const std::array<double, 3>& corner, const Vec3& normal, double distance) {
  const Vec3 start = ray.at(ray.t_min) - Vec3(corner[0], corner[1], corner[2]);
  const double away = normal.dot(start) / normal.length();
  const double rise = normal.dot(ray.direction) * static_cast<double>(ray.start_side);
  return !(std::abs(away) > distance) && !(rise < 0);  // written so that one without a normal counts
}

}  // namespace rhoray::render
