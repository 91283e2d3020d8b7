#pragma once

#include "formats/base/checks.h"
#include "formats/base/vector.h"

namespace rhoray::render {

/// How a ray passes a plane.
struct PlanePassage {
  double along;  ///< speed towards the side of the normal
  double t;      ///< where it passes the plane; infinite or NaN where along is 0
  double ahead;  ///< above 0: the ray starts on the other side
};

/// The one function that computes when a ray passes a plane, so that all callers get the same bits
/// for a plane, whichever way its normal points. The error of t is at most the rounding of two
/// products of three terms and of a quotient.
RHORAY_INLINE PlanePassage passage_of(const Vec3& point, const Vec3& normal, const Vec3& origin,
                                      const Vec3& direction) {
  const double along = normal.x * direction.x + normal.y * direction.y + normal.z * direction.z;
  const double ahead =
      normal.x * (point.x - origin.x) + normal.y * (point.y - origin.y) + normal.z * (point.z - origin.z);
  return {along, ahead / along, ahead};
}

}  // namespace rhoray::render
