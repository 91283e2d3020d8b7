#pragma once

#include "render/scene.h"
#include "render/shade/diffuse.h"
#include "render/shade/facing.h"
#include "render/shade/field_color.h"
#include "render/shade/fog.h"
#include "render/shade/intensity.h"
#include "render/shade/lanes.h"
#include "render/shade/lights.h"
#include "render/shade/occlusion.h"
#include "render/shade/received.h"
#include "render/shade/specular.h"
#include "render/shade/texture.h"

namespace rhoray::render {

/// Effects that a layer needs besides finding the hit. Effects outside the set are neither computed
/// nor read.
struct EffectSet {
  bool diffuse = false;
  bool smooth_normals = false;
  bool field_color = false;
  bool texture = false;
  bool specular = false;
  bool intensity = false;
  bool true_colors = false;   ///< the field's own colours
  bool lights = false;        ///< lights other than one white light at the eye
  bool shadows = false;       ///< rays towards lights are traced
  bool soft_shadows = false;  ///< several rays per hit, towards area lights
  bool occlusion = false;     ///< rays into the surroundings are traced
  bool fog = false;
};

/// Derives the effects from the layer, not from switches. An isosurface is lit. One with gloss has
/// a highlight, one that names a field is coloured by it, and one that names a texture is covered
/// by it. A projection shows intensity.
EffectSet effects_called_for(const Layer& layer);

/// The same for a layer in its scene. Shadows need a shining light that casts them, an occluder,
/// and a surface that shows lights at all. Occlusion needs a radius, ambient light, and an
/// occluder.
EffectSet effects_called_for(const Scene& scene, const Layer& layer);

/// True for opaque isosurfaces and triangles.
bool holds_light_back(const Layer& layer);

/// Lights on a layer other than a white light at the eye, and the share of them that reaches its
/// hits. Read only if the effects contain lights or fog.
struct Surroundings {
  const LayerLights* lights = nullptr;
  const ReceivedLight* received = nullptr;
  const Fog* fog = nullptr;
};

/// Computes the colours of a surface under several lights.
/// @param base  the surface's own colours
RHORAY_INLINE void shade_under_lights(const Material& surface, const EffectSet& effects, const Facing& facing,
                                      const Surroundings& surroundings, const RayBatch& rays, const HitBatch& hits,
                                      std::size_t first, const Colors& base, Colors& colors) {
  const LayerLights& of_layer = *surroundings.lights;
  Directions to_eye, normal, to_light;
  find_directions_to_eye(of_layer.world_from_data, rays, first, to_eye);
  facing.normals(rays, hits, first, to_eye, normal);
  Lanes ambient, shares, cosines;
  ambient.fill(static_cast<float>(surface.ambient));
  if (effects.occlusion) darken_ambient(surroundings.received->ambient.data() + first, ambient);
  Colors arriving{ambient, ambient, ambient};
  for (std::size_t l = 0; l < of_layer.lights.size(); ++l) {
    const LayerLights::One& light = of_layer.lights[l];
    shares.fill(1);
    if (effects.shadows && light.casts_shadows) surroundings.received->find_shares(l, first, shares);
    find_directions_to_light(light, of_layer.world_from_data, rays, hits, first, to_eye, to_light);
    find_cosines(normal, to_light, cosines);
    add_arriving(light.color * static_cast<float>(1 - surface.ambient), shares, cosines, arriving);
    if (effects.specular) add_specular(surface, light.color, shares, cosines, normal, to_light, to_eye, colors);
  }
  add_sent_back(base, arriving, colors);
}

/// Finds the surface's own colours, as seen under white light.
RHORAY_INLINE void find_own_colors(const Material& surface, const EffectSet& effects, const double* field_values,
                                   const CoveringColors* texture, Colors& base) {
  if (effects.field_color)
    find_field_colors(surface, field_values, base);
  else
    fill_colors(Imath::V3f(surface.color), base);
  if (effects.texture) cover(*texture, base);
}

/// Computes the colours of the group of hits that begins at `first`. Colours of misses are
/// undefined.
/// @param field_values  values of the surface's colour field at the group's hits; otherwise not
///                      read
/// @param texture       texture colours at the hits; read only if the effects contain a texture
RHORAY_INLINE void shade(const Layer& layer, const EffectSet& effects, const Facing& facing, const RayBatch& rays,
                         const HitBatch& hits, std::size_t first, const double* field_values, Colors& colors,
                         const Surroundings& surroundings = {}, const CoveringColors* texture = nullptr) {
  colors = {};
  if (effects.intensity) find_intensity(layer.map, layer.scale, layer.window, hits.value.data() + first, colors);
  if (effects.true_colors) find_field_colors(layer.material, field_values, colors);
  if (effects.diffuse && effects.lights) {
    Colors base;
    find_own_colors(layer.material, effects, field_values, texture, base);
    shade_under_lights(layer.material, effects, facing, surroundings, rays, hits, first, base, colors);
  } else if (effects.diffuse) {
    Lanes cosines;
    facing.cosines(rays, hits, first, cosines);
    if (effects.field_color || effects.texture) {
      Colors base;
      find_own_colors(layer.material, effects, field_values, texture, base);
      add_diffuse(layer.material, base, cosines, colors);
    } else {
      add_diffuse(layer.material, cosines, colors);
    }
    if (effects.specular) add_specular(layer.material, cosines, colors);
  }
  if (effects.fog) mix_fog(*surroundings.fog, hits.t.data() + first, colors);
}

}  // namespace rhoray::render
