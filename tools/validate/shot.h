#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>

#include "tools/validate/geometry.h"

namespace rhoray::tools::validate {

/// Converts a ray to CGAL's representation: two points. The second point is rounded, so it is
/// placed beyond all targets. Then no point in between moves by more than a few roundings of its
/// coordinates.
inline CGAL::Exact_predicates_inexact_constructions_kernel::Ray_3 shot_of(const render::Ray& ray, const Box3& targets) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  const double reach = 2 * ((targets.center() - ray.origin).length() + targets.size().length() + ray.origin.length());
  const double scale = std::exp2(std::ceil(std::log2(reach / ray.direction.length())));
  const Vec3 end = ray.origin + scale * ray.direction;
  return {Point(ray.origin.x, ray.origin.y, ray.origin.z), Point(end.x, end.y, end.z)};
}

}  // namespace rhoray::tools::validate
