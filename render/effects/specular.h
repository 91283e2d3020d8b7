#pragma once

#include "render/effects/lanes.h"
#include "render/effects/power.h"
#include "render/scene.h"

namespace rhoray::render {

/// Blinn-Phong highlight of a white light at the eye: there the half vector is the direction to the eye itself.
/// @param cosines  of the angle between the normal and the direction to the eye, in [0, 1]
RHORAY_INLINE void add_specular(const Surface& surface, const Lanes& cosines, Colors& colors) {
  const auto strength = static_cast<float>(surface.specular), shininess = static_cast<float>(surface.shininess);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float highlight = strength * power(cosines[i], shininess);
    colors.red[i] += highlight;
    colors.green[i] += highlight;
    colors.blue[i] += highlight;
  }
}

}  // namespace rhoray::render
