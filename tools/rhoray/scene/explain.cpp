#include "tools/rhoray/scene/explain.h"

#include <algorithm>

#include "render/called_for.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/method_names.h"
#include "tools/rhoray/scene/plane_text.h"
#include "tools/rhoray/scene/tables.h"

namespace rhoray::tools {

namespace {

std::string unit_text(const render::Volume& volume) {
  const std::string& unit = volume.field().unit;
  return unit.empty() ? "" : " " + unit;
}

/// isosurface 500 HU of 'density' in head.rho; triangles of heart.rho
std::string shown_text(const render::Layer& layer, const ResolvedScene& plan) {
  const render::Volume& volume = plan.volumes[layer.volume];
  if (layer.mode == render::Mode::triangles) return concat("triangles of ", plan.data[layer.volume].file.string());
  const std::string of =
      concat(unit_text(volume), " of '", volume.field().name, "' in ", plan.data[layer.volume].file.string());
  if (layer.mode == render::Mode::slice) return concat("slice ", text_of_slice(layer.plane), of);
  if (layer.mode == render::Mode::mip)
    return concat("largest values from ", layer.window.lo, " to ", layer.window.hi, of);
  return concat("isosurface ", layer.isovalue, of);
}

std::string why_method(const SceneSpec& scene_spec, const LayerSpec& layer) {
  if (layer.type == LayerType::slice) return "used for every slice";
  if (!layer.method.empty() || !layer.accuracy.empty() || !scene_spec.accuracy.empty()) return "requested";
  return "default";
}

Json explained_layer(const SceneSpec& scene_spec, const ResolvedScene& plan, std::size_t index) {
  const render::Layer& layer = plan.scene.layers[index];
  const LayerOrigin& origin = plan.origins[index];
  const render::Volume& volume = plan.volumes[layer.volume];
  const MethodOption method = option_of(layer.method, layer.mode, volume.is_mesh());
  Json json{{"layer", index},
            {"wish", origin.spec},
            {"shows", shown_text(layer, plan)},
            {"isovalue_from", origin.isovalue_from},
            {"method", method.word},
            {"method_because", why_method(scene_spec, scene_spec.layers[origin.spec])},
            {"kernel", render::machine_for(volume, layer, plan.frame)},
            {"effects", Json::array()}};
  for (const render::EffectReason& reason : render::reasons_for_effects(plan.scene, layer))
    json["effects"].push_back({{"effect", reason.effect}, {"called_for", reason.called_for}, {"why", reason.why}});
  return json;
}

std::string vector_text(const Vec3& v) {
  return concat("(", rounded(v.x, 3), ", ", rounded(v.y, 3), ", ", rounded(v.z, 3), ")");
}

/// ", casts soft shadows: 3 degrees wide, 16 rays a hit"; nothing of a light that casts none
std::string shadows_text(const render::Light& light) {
  if (!light.casts_shadows) return {};
  if (!(light.size > 0)) return ", casts shadows";
  const std::string size = light.kind == render::Light::Kind::point ? concat("a ball of radius ", light.size)
                                                                    : concat(light.size, " degrees wide");
  return concat(", casts soft shadows: ", size, ", ", light.samples, light.samples == 1 ? " ray" : " rays", " per hit");
}

/// directional, from (0.6, -0.6, 0.5), casts shadows
std::string light_text(const render::Light& light) {
  const std::string brightness = concat(", colour ", vector_text(light.color));
  switch (light.kind) {
    case render::Light::Kind::head:
      return "at the camera" + brightness;
    case render::Light::Kind::directional:
      return concat("from ", vector_text(light.place), brightness, shadows_text(light));
    case render::Light::Kind::point:
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

Json explained(const SceneSpec& scene_spec, const ResolvedScene& plan) {
  Json json{{"layers", Json::array()}, {"lights", Json::array()}, {"left_out", plan.notes}};
  json["antialiasing"] = antialiasing_text(plan);
  for (const render::Light& light : plan.scene.lights) json["lights"].push_back(light_text(light));
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i)
    json["layers"].push_back(explained_layer(scene_spec, plan, i));
  for (std::size_t i = 0; i < scene_spec.layers.size(); ++i)
    if (!scene_spec.layers[i].visible)
      json["left_out"].push_back(concat("/layers/", i, ": not traced: \"visible\" is false"));
  for (const DataSpec& data : scene_spec.data)
    if (!is_opened(data, plan))
      json["left_out"].push_back(
          concat("data \"", data.name, "\": ", data.file.string(), " is not opened; no visible layer uses it"));
  return json;
}

std::vector<std::string> explained_lines(const Json& explanation) {
  std::vector<std::string> lines;
  for (const Json& layer : explanation["layers"]) {
    const auto text = [&](const char* key) { return layer[key].get<std::string>(); };
    const std::string from = text("isovalue_from"), kernel = text("kernel");
    lines.push_back(concat("layer ", layer["layer"].get<std::size_t>(), ": ", text("shows"),
                           from.empty() || from == "given" ? "" : concat(" (", from, ")")));
    lines.push_back(concat("  method ", text("method"), " (", text("method_because"), "), ",
                           kernel == "scalar" ? "one ray at a time" : concat("wide ", kernel, " kernel")));
    for (const Json& effect : layer["effects"])
      lines.push_back(concat(effect["called_for"].get<bool>() ? "  " : "  no ", effect["effect"].get<std::string>(),
                             ": ", effect["why"].get<std::string>()));
  }
  const Json& lights = explanation["lights"];
  for (std::size_t i = 0; i < lights.size(); ++i)
    lines.push_back(concat("light ", i, ": ", lights[i].get<std::string>()));
  lines.push_back(explanation["antialiasing"].get<std::string>());
  for (const Json& note : explanation["left_out"]) lines.push_back(note.get<std::string>());
  return lines;
}

}  // namespace rhoray::tools
