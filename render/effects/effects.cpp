#include "render/effects/effects.h"

namespace rhoray::render {

EffectSet effects_called_for(const Layer& layer) {
  const bool is_surface = layer.mode == Mode::isosurface;
  return {.diffuse = is_surface, .specular = is_surface && layer.surface.specular > 0, .intensity = !is_surface};
}

}  // namespace rhoray::render
