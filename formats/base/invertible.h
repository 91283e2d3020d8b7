#pragma once

#include <cmath>

#include "formats/base/affine.h"

namespace rhoray {

/// False when the axes span no volume. Also false when a number on the way to the inverse leaves
/// the range of doubles, for example with an axis of 1e-320.
inline bool is_invertible(const Affine& map) {
  const double determinant = map.determinant();
  if (determinant == 0 || !std::isfinite(determinant)) return false;
  const Affine inverse = map.inverse();
  for (const Vec3& v :
       {map.x_axis, map.y_axis, map.z_axis, map.origin, inverse.x_axis, inverse.y_axis, inverse.z_axis, inverse.origin})
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) return false;
  return true;
}

}  // namespace rhoray
