#pragma once

#include <cmath>

#include "formats/base/checks.h"

namespace rhoray::render {

/// Which side of the isosurface a value lies on. Inside is value >= isovalue: zero has a side, so a crossing is a
/// change of one bit and needs no tolerance.
/// @param difference  value - isovalue, in which -0 counts as 0
RHORAY_INLINE bool is_inside(double difference) {
  return !std::signbit(difference + 0.0);
}

}  // namespace rhoray::render
