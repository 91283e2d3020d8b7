#pragma once

#include "render/effects/diffuse.h"
#include "render/effects/facing.h"
#include "render/effects/field_color.h"
#include "render/effects/intensity.h"
#include "render/effects/lanes.h"
#include "render/effects/specular.h"
#include "render/scene.h"

namespace rhoray::render {

/// What a layer calls for beyond finding the hit. What is not in the set is neither computed nor read.
struct EffectSet {
  bool diffuse = false;
  bool smooth_normals = false;
  bool field_color = false;
  bool specular = false;
  bool intensity = false;
};

/// Reads the layer, not switches: an isosurface is lit, one with gloss has a highlight, one that names a field is
/// coloured by it; a projection shows intensity.
EffectSet effects_called_for(const Layer& layer);

/// Colours of the group of hits that begins at `first`; any numbers where nothing was hit.
/// @param field_values  at the hits of the group, of the field that the surface is coloured by; else not read
RHORAY_INLINE void shade(const Layer& layer, const EffectSet& effects, const Facing& facing, const RayBatch& rays,
                         const HitBatch& hits, std::size_t first, const double* field_values, Colors& colors) {
  colors = {};
  if (effects.intensity) add_intensity(layer.window, hits.value.data() + first, colors);
  if (!effects.diffuse) return;
  Lanes cosines;
  facing.cosines(rays, hits, first, cosines);
  if (effects.field_color) {
    Colors base;
    find_field_colors(layer.surface, field_values, base);
    add_diffuse(layer.surface, base, cosines, colors);
  } else {
    add_diffuse(layer.surface, cosines, colors);
  }
  if (effects.specular) add_specular(layer.surface, cosines, colors);
}

}  // namespace rhoray::render
