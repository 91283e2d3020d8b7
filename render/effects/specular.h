#pragma once

#include <cmath>

#include "render/scene.h"

namespace rhoray::render {

/// Blinn-Phong highlight of a white light at the eye: there the half vector is the direction to the eye itself.
/// @param cosine  of the angle between the normal and the direction to the eye, in [0, 1]
inline Vec3 specular(const Surface& surface, double cosine) {
  const double highlight = surface.specular * std::pow(cosine, surface.shininess);
  return {highlight, highlight, highlight};
}

}  // namespace rhoray::render
