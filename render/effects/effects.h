#pragma once

#include "render/scene.h"

namespace rhoray::render {

/// What a scene calls for beyond finding the hit. What is not in the set is neither computed nor read.
struct EffectSet {
  bool diffuse = false;
  bool specular = false;
  bool intensity = false;
};

/// Reads the scene, not switches: an isosurface is lit, one with gloss has a highlight, a projection shows intensity.
EffectSet effects_called_for(const Scene& scene);

/// What is known of a hit when it is to get its colour.
struct ShadingPoint {
  Vec3 normal_world;  ///< unit length, towards the eye; 0 where the field has no gradient
  Vec3 to_eye_world;  ///< unit length
  double value = 0;
};

/// Linear RGB of one hit.
Vec3 shade(const Scene& scene, const EffectSet& effects, const ShadingPoint& point);

}  // namespace rhoray::render
