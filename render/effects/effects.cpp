#include "render/effects/effects.h"

namespace rhoray::render {

EffectSet effects_called_for(const Scene& scene) {
  const bool is_surface = scene.mode == Mode::isosurface;
  return {.diffuse = is_surface, .specular = is_surface && scene.surface.specular > 0, .intensity = !is_surface};
}

}  // namespace rhoray::render
