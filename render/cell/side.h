#pragma once

#include <cmath>

#include "formats/base/checks.h"

namespace rhoray::render {

/// Which side of the isosurface a value lies on. Inside means value >= isovalue: zero has a side,
/// so a crossing is a change of one bit and needs no tolerance.
/// @param difference  value - isovalue, in which -0 counts as 0
template <class Real>
RHORAY_INLINE bool is_inside(Real difference) {
  return !std::signbit(difference + Real(0));
}

}  // namespace rhoray::render
