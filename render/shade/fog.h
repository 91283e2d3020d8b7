#pragma once

#include "render/scene.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Blends the colours of a group's hits into the fog's colour, in proportion to their distance
/// within the fog's range.
/// @param t  distances
RHORAY_INLINE void mix_fog(const Fog& fog, const double* t, Colors& colors) {
  const double low = fog.range.lo, width = fog.range.hi - fog.range.lo;
  const Imath::V3f color(fog.color);
  for (std::size_t i = 0; i < colors.red.size(); ++i) {
    const double share = (t[i] - low) / width;
    // Written so that a NaN becomes 0.
    const auto above = static_cast<float>(share > 0 ? share : 0);
    const float of_fog = above < 1 ? above : 1;
    colors.red[i] += of_fog * (color.x - colors.red[i]);
    colors.green[i] += of_fog * (color.y - colors.green[i]);
    colors.blue[i] += of_fog * (color.z - colors.blue[i]);
  }
}

}  // namespace rhoray::render
