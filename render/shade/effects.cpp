#include "render/shade/effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rhoray::render {

namespace {

bool shines(const Light& light) {
  return light.color != Vec3(0, 0, 0);
}

/// True if anything occludes light.
bool has_opaque_surface(const Scene& scene) {
  return std::any_of(scene.layers.begin(), scene.layers.end(), holds_light_back);
}

/// Lights do not affect a surface that has ambient light only.
bool shows_lights(const Material& surface) {
  return surface.ambient < 1 || surface.specular > 0;
}

bool casts_visible_shadows(const Light& light) {
  return light.casts_shadows && light.kind != Light::Kind::head && shines(light);
}

bool is_wide(const Light& light) {
  return light.size > 0;
}

/// Extent of a light for its directions. Directional: height of the cap of the unit sphere that it
/// covers; point: its radius.
double extent_of(const Light& light) {
  if (light.kind == Light::Kind::point) return light.size;
  constexpr double radians_per_degree = std::numbers::pi / 180;
  const double sine = std::sin(light.size * radians_per_degree / 4);
  return 2 * sine * sine;
}

}  // namespace

bool holds_light_back(const Layer& layer) {
  return (layer.mode == Mode::isosurface || layer.mode == Mode::triangles) && layer.material.opacity == 1;
}

EffectSet effects_called_for(const Layer& layer) {
  const bool is_slice = layer.mode == Mode::slice, is_mip = layer.mode == Mode::mip;
  const Material& surface = layer.material;
  const bool is_lit = !is_mip && (!is_slice || surface.lit);
  return {.diffuse = is_lit,
          .smooth_normals = is_lit && !is_slice && surface.normals == Normals::smooth,
          .field_color = !is_mip && surface.color_by.has_value(),
          .texture = !is_mip && !is_slice && surface.texture.has_value(),
          .specular = is_lit && surface.specular > 0,
          .intensity = is_mip,
          .true_colors = is_slice && !is_lit};
}

EffectSet effects_called_for(const Scene& scene, const Layer& layer) {
  EffectSet effects = effects_called_for(layer);
  effects.fog = scene.fog.has_value() && layer.mode != Mode::mip;
  if (!effects.diffuse) return effects;
  effects.shadows = shows_lights(layer.material) && has_opaque_surface(scene) &&
                    std::any_of(scene.lights.begin(), scene.lights.end(), casts_visible_shadows);
  effects.soft_shadows =
      effects.shadows && std::any_of(scene.lights.begin(), scene.lights.end(),
                                     [](const Light& light) { return casts_visible_shadows(light) && is_wide(light); });
  effects.occlusion = scene.occlusion.samples > 0 && scene.occlusion.radius > 0 && layer.material.ambient > 0 &&
                      has_opaque_surface(scene);
  effects.lights = effects.occlusion || !is_lit_from_the_eye_alone(scene);
  return effects;
}

LayerLights lights_of(const Scene& scene, const Affine& world_from_data) {
  LayerLights of_layer{.lights = {}, .world_from_data = world_from_data};
  const Affine data_from_world = world_from_data.inverse();
  for (const Light& light : scene.lights) {
    if (!shines(light)) continue;
    const bool is_point = light.kind == Light::Kind::point;
    of_layer.lights.push_back({.kind = light.kind,
                               .casts_shadows = casts_visible_shadows(light),
                               .place = is_point ? data_from_world.point(light.place) : light.place.normalized(),
                               .color = Imath::V3f(light.color),
                               .extent = extent_of(light),
                               .rays = is_wide(light) ? light.samples : 1});
  }
  return of_layer;
}

bool is_lit_from_the_eye_alone(const Scene& scene) {
  std::size_t shining = 0, white_heads = 0;
  for (const Light& light : scene.lights) {
    shining += shines(light);
    white_heads += light.kind == Light::Kind::head && light.color == Vec3(1, 1, 1);
  }
  return shining == 1 && white_heads == 1;
}

}  // namespace rhoray::render
