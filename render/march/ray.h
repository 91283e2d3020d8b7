#pragma once

#include <cmath>
#include <limits>

#include "formats/base/checks.h"
#include "formats/base/vector.h"

namespace rhoray::render {

/// Points origin + t * direction with t_min <= t <= t_max, in the frame of the room that holds it. The direction need
/// not be of unit length: kernels work in the lattice's frame, where t stays the distance in world units.
struct Ray {
  Vec3 origin;
  Vec3 direction;
  double t_min = 0;
  double t_max = std::numeric_limits<double>::infinity();

  Vec3 at(double t) const { return origin + t * direction; }
};

/// When a ray passes the planes x = k, y = k, z = k of a lattice.
///
/// Every level of a hierarchy asks this one function with whole numbers of leaf cells, so all levels agree bit for bit
/// on when a plane is passed, and times rise with the order of planes along the ray because rounding is monotone
/// (nothing is accumulated from step to step).
class PlaneTimes {
 public:
  RHORAY_INLINE explicit PlaneTimes(const Ray& ray) : origin_(ray.origin) {
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray.direction[axis];
      inverse_[axis] = 1 / d;
      // A component whose inverse overflows (below 6e-309) does not move, unless the whole direction is as small.
      step_[axis] = !std::isfinite(inverse_[axis]) ? 0 : d > 0 ? 1 : -1;
    }
  }

  /// +1, -1, or 0 on an axis along which the ray never passes a plane.
  RHORAY_INLINE int step(int axis) const { return step_[axis]; }

  /// Only on an axis that moves.
  RHORAY_INLINE double at(int axis, std::int64_t plane) const {
    return (static_cast<double>(plane) - origin_[axis]) * inverse_[axis];
  }

 private:
  Vec3 origin_;
  Vec3 inverse_;
  int step_[3];
};

}  // namespace rhoray::render
