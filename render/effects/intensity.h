#pragma once

#include <algorithm>
#include <cmath>

#include "render/scene.h"

namespace rhoray::render {

/// The grey of a value in a maximum-intensity projection: black at the low end of the window, white at its high end.
/// Shares of the window become shares of the sRGB code, so that steps look even; the result is the linear light of that
/// code.
inline Vec3 intensity(const Interval<double>& window, double value) {
  const double width = window.hi - window.lo;
  const double share = width > 0 ? std::clamp((value - window.lo) / width, 0.0, 1.0) : value >= window.hi ? 1.0 : 0.0;
  const double light = share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  return {light, light, light};
}

}  // namespace rhoray::render
