#include "render/effects/effects.h"

#include <algorithm>

#include "render/effects/diffuse.h"
#include "render/effects/intensity.h"
#include "render/effects/specular.h"

namespace rhoray::render {

EffectSet effects_called_for(const Scene& scene) {
  const bool is_surface = scene.mode == Mode::isosurface;
  return {.diffuse = is_surface, .specular = is_surface && scene.surface.specular > 0, .intensity = !is_surface};
}

Vec3 shade(const Scene& scene, const EffectSet& effects, const ShadingPoint& point) {
  Vec3 color(0, 0, 0);
  if (effects.intensity) color += intensity(scene.window, point.value);
  if (!effects.diffuse) return color;
  // A hit without a gradient faces the eye: it is lit, and no NaN gets into the picture.
  const bool has_normal = point.normal_world != Vec3(0, 0, 0);
  const double cosine = has_normal ? std::clamp(point.normal_world.dot(point.to_eye_world), 0.0, 1.0) : 1.0;
  color += diffuse(scene.surface, cosine);
  if (effects.specular) color += specular(scene.surface, cosine);
  return color;
}

}  // namespace rhoray::render
