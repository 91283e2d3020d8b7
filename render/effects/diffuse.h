#pragma once

#include "render/effects/lanes.h"
#include "render/scene.h"

namespace rhoray::render {

/// Lambert's law for a light at the eye, over a constant share of ambient light. Both sides of a surface look alike.
/// @param cosines  of the angle between the normal and the direction to the eye, in [0, 1]
RHORAY_INLINE void add_diffuse(const Surface& surface, const Lanes& cosines, Colors& colors) {
  const auto ambient = static_cast<float>(surface.ambient);
  const Imath::V3f color(surface.color);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float light = ambient + (1 - ambient) * cosines[i];
    colors.red[i] += light * color.x;
    colors.green[i] += light * color.y;
    colors.blue[i] += light * color.z;
  }
}

/// The same for a surface whose colour differs from hit to hit.
RHORAY_INLINE void add_diffuse(const Surface& surface, const Colors& base, const Lanes& cosines, Colors& colors) {
  const auto ambient = static_cast<float>(surface.ambient);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float light = ambient + (1 - ambient) * cosines[i];
    colors.red[i] += light * base.red[i];
    colors.green[i] += light * base.green[i];
    colors.blue[i] += light * base.blue[i];
  }
}

}  // namespace rhoray::render
