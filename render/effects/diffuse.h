#pragma once

#include "render/scene.h"

namespace rhoray::render {

/// Lambert's law for a light at the eye, over a constant share of ambient light. Both sides of a surface look alike.
/// @param cosine  of the angle between the normal and the direction to the eye, in [0, 1]
inline Vec3 diffuse(const Surface& surface, double cosine) {
  return (surface.ambient + (1 - surface.ambient) * cosine) * surface.color;
}

}  // namespace rhoray::render
