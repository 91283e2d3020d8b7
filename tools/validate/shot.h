#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>

#include "tools/validate/geometry.h"

namespace rhoray::tools::validate {

/// A ray in CGAL's words: two points. The second one is rounded, so it is put beyond all that can be hit; no place on
/// the way then moves by more than a few roundings of its coordinates.
inline CGAL::Exact_predicates_inexact_constructions_kernel::Ray_3 shot_of(const render::Ray& ray, const Box3& targets) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  const double reach = 2 * ((targets.center() - ray.origin).length() + targets.size().length() + ray.origin.length());
  const double scale = std::exp2(std::ceil(std::log2(reach / ray.direction.length())));
  const Vec3 end = ray.origin + scale * ray.direction;
  return {Point(ray.origin.x, ray.origin.y, ray.origin.z), Point(end.x, end.y, end.z)};
}

}  // namespace rhoray::tools::validate
