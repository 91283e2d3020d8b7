#pragma once

#include "render/scene.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Adds Lambert's law for a light at the eye to a constant share of ambient light. Both sides of a
/// surface are shaded alike.
/// @param cosines  of the angle between the normal and the direction to the eye, in [0, 1]
RHORAY_INLINE void add_diffuse(const Material& surface, const Lanes& cosines, Colors& colors) {
  const auto ambient = static_cast<float>(surface.ambient);
  const Imath::V3f color(surface.color);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float light = ambient + (1 - ambient) * cosines[i];
    colors.red[i] += light * color.x;
    colors.green[i] += light * color.y;
    colors.blue[i] += light * color.z;
  }
}

/// The same for a surface whose colour varies from hit to hit.
RHORAY_INLINE void add_diffuse(const Material& surface, const Colors& base, const Lanes& cosines, Colors& colors) {
  const auto ambient = static_cast<float>(surface.ambient);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float light = ambient + (1 - ambient) * cosines[i];
    colors.red[i] += light * base.red[i];
    colors.green[i] += light * base.green[i];
    colors.blue[i] += light * base.blue[i];
  }
}

/// Adds the light that arrives at hits, by Lambert's law.
/// @param color    of the light
/// @param shares   of the light that reach the hits
/// @param cosines  of the angle between the normal and the direction to the light; below 0 the
///                 light is behind the surface
RHORAY_INLINE void add_arriving(const Imath::V3f& color, const Lanes& shares, const Lanes& cosines, Colors& arriving) {
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    // Written so that a NaN becomes 0.
    const float light = cosines[i] > 0 ? shares[i] * cosines[i] : 0;
    arriving.red[i] += light * color.x;
    arriving.green[i] += light * color.y;
    arriving.blue[i] += light * color.z;
  }
}

/// Adds the arriving light that a surface reflects.
RHORAY_INLINE void add_sent_back(const Colors& base, const Colors& arriving, Colors& colors) {
  for (std::size_t i = 0; i < base.red.size(); ++i) {
    colors.red[i] += base.red[i] * arriving.red[i];
    colors.green[i] += base.green[i] * arriving.green[i];
    colors.blue[i] += base.blue[i] * arriving.blue[i];
  }
}

}  // namespace rhoray::render
