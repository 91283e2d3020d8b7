#include "render/document.h"

#include <algorithm>

#include "formats/base/number_text.h"
#include "render/called_for.h"
#include "render/document/slices.h"
#include "render/document/tables.h"
#include "render/method_words.h"

namespace rhoray::render {

namespace {

std::string unit_text(const Dataset& dataset) {
  const std::string& unit = dataset.field().unit;
  return unit.empty() ? "" : " " + unit;
}

/// isosurface 500 HU of 'density' in head.rho; triangles of heart.rho
std::string shown_text(const Layer& layer, const ResolvedScene& plan) {
  const Dataset& dataset = plan.datasets[layer.dataset];
  if (layer.mode == Mode::triangles && dataset.has_fields())
    return concat("boundary of ", plan.data[layer.dataset].file.string());
  if (layer.mode == Mode::triangles) return concat("triangles of ", plan.data[layer.dataset].file.string());
  const std::string of =
      concat(unit_text(dataset), " of '", dataset.field().name, "' in ", plan.data[layer.dataset].file.string());
  if (layer.mode == Mode::slice) return concat("slice ", text_of_slice(layer.plane), of);
  if (layer.mode == Mode::mip) return concat("largest values from ", layer.window.lo, " to ", layer.window.hi, of);
  return concat("isosurface ", layer.isovalue, of);
}

std::string why_method(const SceneSpec& scene_spec, const LayerSpec& layer) {
  if (layer.type == LayerType::slice) return "used for every slice";
  if (!layer.method.empty() || !layer.accuracy.empty() || !scene_spec.accuracy.empty()) return "requested";
  return "default";
}

Explanation::Layer explained_layer(const SceneSpec& scene_spec, const ResolvedScene& plan, std::size_t index) {
  const Layer& layer = plan.scene.layers[index];
  const LayerOrigin& origin = plan.origins[index];
  const Dataset& dataset = plan.datasets[layer.dataset];
  return {.spec = origin.spec,
          .shows = shown_text(layer, plan),
          .isovalue_from = origin.isovalue_from,
          .method = option_of(layer.method, layer.mode, dataset.is_mesh()).word,
          .method_because = why_method(scene_spec, scene_spec.layers[origin.spec]),
          .kernel = std::string(machine_for(dataset, layer, plan.frame)),
          .effects = reasons_for_effects(plan.scene, layer)};
}

std::string vector_text(const Vec3& v) {
  return concat("(", rounded(v.x, 3), ", ", rounded(v.y, 3), ", ", rounded(v.z, 3), ")");
}

/// ", casts soft shadows: 3 degrees wide, 16 rays a hit"; nothing of a light that casts none
std::string shadows_text(const Light& light) {
  if (!light.casts_shadows) return {};
  if (!(light.size > 0)) return ", casts shadows";
  const std::string size =
      light.kind == Light::Kind::point ? concat("a ball of radius ", light.size) : concat(light.size, " degrees wide");
  return concat(", casts soft shadows: ", size, ", ", light.samples, light.samples == 1 ? " ray" : " rays", " per hit");
}

/// directional, from (0.6, -0.6, 0.5), casts shadows
std::string light_text(const Light& light) {
  const std::string brightness = concat(", colour ", vector_text(light.color));
  switch (light.kind) {
    case Light::Kind::head:
      return "at the camera" + brightness;
    case Light::Kind::directional:
      return concat("from ", vector_text(light.place), brightness, shadows_text(light));
    case Light::Kind::point:
      return concat("at ", vector_text(light.place), brightness, shadows_text(light));
  }
  return {};
}

std::string antialiasing_text(const ResolvedScene& plan) {
  const int most = plan.frame.antialiasing;
  if (most == 1) return "no antialiasing: one ray through the centre of each pixel";
  return concat("antialiasing: up to ", most, " rays per pixel at edges, one elsewhere");
}

bool is_opened(const DataSpec& data, const ResolvedScene& plan) {
  const auto is_this = [&](const DataSpec& each) { return each.name == data.name; };
  return std::any_of(plan.data.begin(), plan.data.end(), is_this) ||
         std::any_of(plan.texture_data.begin(), plan.texture_data.end(), is_this);
}

}  // namespace

Explanation explain(const SceneSpec& scene_spec, const ResolvedScene& plan) {
  Explanation all{.antialiasing = antialiasing_text(plan), .left_out = plan.notes};
  for (const Light& light : plan.scene.lights) all.lights.push_back(light_text(light));
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) all.layers.push_back(explained_layer(scene_spec, plan, i));
  for (std::size_t i = 0; i < scene_spec.layers.size(); ++i)
    if (!scene_spec.layers[i].visible)
      all.left_out.push_back(concat("/layers/", i, ": not traced: \"visible\" is false"));
  for (const DataSpec& data : scene_spec.data)
    if (!is_opened(data, plan))
      all.left_out.push_back(
          concat("data \"", data.name, "\": ", data.file.string(), " is not opened; no visible layer uses it"));
  return all;
}

}  // namespace rhoray::render
