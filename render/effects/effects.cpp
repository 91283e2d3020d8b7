#include "render/effects/effects.h"

namespace rhoray::render {

EffectSet effects_called_for(const Layer& layer) {
  const bool is_surface = layer.mode != Mode::mip;
  const Surface& surface = layer.surface;
  return {.diffuse = is_surface,
          .smooth_normals = is_surface && surface.normals == Normals::smooth,
          .field_color = is_surface && surface.color_by.has_value(),
          .specular = is_surface && surface.specular > 0,
          .intensity = !is_surface};
}

}  // namespace rhoray::render
