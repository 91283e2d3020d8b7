#pragma once

#include <cmath>

#include "render/scene.h"
#include "render/shade/lanes.h"
#include "render/shade/power.h"

namespace rhoray::render {

/// Adds the Blinn-Phong highlight of a white light at the eye. There the half vector is the
/// direction to the eye itself.
/// @param cosines  of the angle between the normal and the direction to the eye, in [0, 1]
RHORAY_INLINE void add_specular(const Material& surface, const Lanes& cosines, Colors& colors) {
  const auto strength = static_cast<float>(surface.specular);
  Lanes powers;
  raise(cosines, surface.shininess, powers);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float highlight = strength * powers[i];
    colors.red[i] += highlight;
    colors.green[i] += highlight;
    colors.blue[i] += highlight;
  }
}

/// Adds the highlight of any light.
/// @param color    of the light
/// @param shares   of the light that reach the hits
/// @param cosines  of the angle between the normal and the direction to the light; no highlight
///                 unless above 0
RHORAY_INLINE void add_specular(const Material& surface, const Imath::V3f& color, const Lanes& shares,
                                const Lanes& cosines, const Directions& normal, const Directions& to_light,
                                const Directions& to_eye, Colors& colors) {
  const auto strength = static_cast<float>(surface.specular);
  Lanes half_cosines, powers;
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float x = to_light.x[i] + to_eye.x[i], y = to_light.y[i] + to_eye.y[i], z = to_light.z[i] + to_eye.z[i];
    const float cosine = (normal.x[i] * x + normal.y[i] * y + normal.z[i] * z) / std::sqrt(x * x + y * y + z * z);
    const float above = cosine > 0 ? cosine : 0;
    half_cosines[i] = above < 1 ? above : 1;
  }
  raise(half_cosines, surface.shininess, powers);
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    const float highlight = cosines[i] > 0 ? shares[i] * (strength * powers[i]) : 0;
    colors.red[i] += highlight * color.x;
    colors.green[i] += highlight * color.y;
    colors.blue[i] += highlight * color.z;
  }
}

}  // namespace rhoray::render
