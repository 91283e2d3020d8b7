#pragma once

#include <cmath>
#include <optional>

#include "render/traverse/ray.h"

namespace rhoray::render {

struct Segment {
  double t_in = 0;
  double t_out = 0;
};

/// The part of a ray inside the closed box between planes 0 and `size`, or nothing. A ray that lies
/// in a face is inside. A ray that touches an edge or a corner, as far as its plane times tell,
/// keeps a part of length zero. Both ends are finite numbers: nothing is returned for a direction
/// of zero, NaN anywhere, an infinite origin or direction, or a t that overflows.
template <class Planes>
RHORAY_INLINE std::optional<Segment> clip_to_lattice(const Ray& ray, const PlaneTimesOf<Planes>& planes,
                                                     const Index3& size) {
  Segment inside{ray.t_min, ray.t_max};
  if (planes.step(0) == 0 && planes.step(1) == 0 && planes.step(2) == 0) return std::nullopt;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(ray.origin[axis]) || !std::isfinite(ray.direction[axis])) return std::nullopt;
    if (planes.step(axis) == 0) {
      const double low = planes.planes().position(axis, 0), high = planes.planes().position(axis, size[axis]);
      if (!(ray.origin[axis] >= low && ray.origin[axis] <= high)) return std::nullopt;
      continue;
    }
    const bool forward = planes.step(axis) > 0;
    const double t_enter = planes.at(axis, forward ? 0 : size[axis]);
    const double t_leave = planes.at(axis, forward ? size[axis] : 0);
    if (!(t_enter <= t_leave)) return std::nullopt;  // written so that a NaN also leaves here
    if (t_enter > inside.t_in) inside.t_in = t_enter;
    if (t_leave < inside.t_out) inside.t_out = t_leave;
  }
  if (!(inside.t_in <= inside.t_out) || !std::isfinite(inside.t_in) || !std::isfinite(inside.t_out))
    return std::nullopt;
  return inside;
}

}  // namespace rhoray::render
