#include "render/called_for.h"

#include <algorithm>
#include <array>

#include "formats/base/text.h"
#include "render/dataset/loaded_dataset.h"
#include "render/query/intersectors.h"
#include "render/shade/effects.h"

namespace rhoray::render {

namespace {

bool is_projection(const Layer& layer) {
  return layer.mode == Mode::mip;
}

constexpr const char* no_surface = "a projection shows values, not a lit surface";

constexpr const char* not_lit = "a slice shows its own colours";

bool is_unlit_slice(const Layer& layer) {
  return layer.mode == Mode::slice && !layer.material.lit;
}

/// Nothing for a continuous linear scale.
std::string scale_text(const ColorScale& scale) {
  return concat(scale.is_logarithmic ? ", on a logarithmic scale" : "",
                scale.levels > 0 ? concat(", in ", scale.levels, " levels") : "");
}

std::string why_diffuse(const Scene&, const Layer& layer) {
  return layer.mode == Mode::slice ? "the slice is lit" : "a surface is lit";
}
std::string why_true_colors(const Scene&, const Layer& layer) {
  return layer.mode != Mode::slice ? "used only by slices" : is_unlit_slice(layer) ? not_lit : "the slice is lit";
}
std::string why_smooth_normals(const Scene&, const Layer& layer) {
  return layer.material.normals == Normals::smooth ? "normals are smooth"
                                                   : "normals are the exact gradient of the hit's cell";
}
std::string why_field_color(const Scene&, const Layer& layer) {
  return layer.material.color_by
             ? concat("coloured by '", layer.material.color_by->field, "'", scale_text(layer.material.color_by->scale))
             : "no field colours the surface";
}
std::string why_texture(const Scene&, const Layer& layer) {
  return layer.material.texture ? concat("covered by the colours in ", layer.material.texture->file().name())
                                : "no texture covers the surface";
}
std::string why_specular(const Scene&, const Layer& layer) {
  return concat("specular is ", layer.material.specular);
}
std::string why_intensity(const Scene&, const Layer& layer) {
  return is_projection(layer) ? concat("a projection shows values from ", layer.window.lo, " to ", layer.window.hi,
                                       scale_text(layer.scale))
                              : "used only by MIP";
}
std::string why_lights(const Scene& scene, const Layer&) {
  if (is_lit_from_the_eye_alone(scene)) return "one white light at the camera";
  return concat(scene.lights.size(), scene.lights.size() == 1 ? " light" : " lights");
}
std::string why_shadows(const Scene& scene, const Layer& layer) {
  if (effects_called_for(scene, layer).shadows) return "a light casts shadows of an opaque surface";
  const bool asked =
      std::any_of(scene.lights.begin(), scene.lights.end(), [](const Light& l) { return l.casts_shadows; });
  return asked ? "none visible: every light is at the camera or has no intensity, or no surface is opaque"
               : "no light casts shadows";
}
std::string why_soft_shadows(const Scene& scene, const Layer& layer) {
  if (!effects_called_for(scene, layer).soft_shadows) return "no light that casts shadows has a size";
  int samples = 0;
  for (const Light& light : scene.lights)
    if (light.casts_shadows && light.size > 0) samples = std::max(samples, light.samples);
  return concat("a light has a size: up to ", samples, " rays per hit and light");
}
std::string why_occlusion(const Scene& scene, const Layer& layer) {
  const Occlusion& occlusion = scene.occlusion;
  if (!(occlusion.radius > 0)) return "its radius is 0";
  if (effects_called_for(scene, layer).occlusion)
    return concat(occlusion.samples, " rays per hit, up to ", occlusion.radius, " away");
  return "there is no ambient light, or no opaque surface";
}
std::string why_fog(const Scene& scene, const Layer&) {
  return scene.fog ? concat("surfaces fade from ", scene.fog->range.lo, " to ", scene.fog->range.hi)
                   : "there is no fog";
}

std::string why_clipped(const Scene& scene, const Layer& layer) {
  if (!scene.clip) return "there is no clip region";
  if (!layer.clipped) return "the layer is not clipped";
  const std::size_t planes = scene.clip->planes.size();
  const std::string box = scene.clip->box ? "a box" : "";
  const std::string of_planes = planes == 0 ? "" : concat(planes, planes == 1 ? " plane" : " planes");
  return concat(scene.clip->cuts_away ? "the inside of " : "rays end at ", box,
                box.empty() || of_planes.empty() ? "" : " and ", of_planes, scene.clip->cuts_away ? " is hidden" : "");
}

struct Row {
  std::string_view effect;
  bool EffectSet::*called_for;
  std::string (*why)(const Scene& scene, const Layer& layer);
};

/// One row for every effect: EffectSet contains exactly one bool for each.
constexpr std::array rows{Row{"diffuse", &EffectSet::diffuse, why_diffuse},
                          Row{"smooth normals", &EffectSet::smooth_normals, why_smooth_normals},
                          Row{"colour by field", &EffectSet::field_color, why_field_color},
                          Row{"texture", &EffectSet::texture, why_texture},
                          Row{"specular", &EffectSet::specular, why_specular},
                          Row{"intensity", &EffectSet::intensity, why_intensity},
                          Row{"true colours", &EffectSet::true_colors, why_true_colors},
                          Row{"lights", &EffectSet::lights, why_lights},
                          Row{"shadows", &EffectSet::shadows, why_shadows},
                          Row{"soft shadows", &EffectSet::soft_shadows, why_soft_shadows},
                          Row{"ambient occlusion", &EffectSet::occlusion, why_occlusion},
                          Row{"fog", &EffectSet::fog, why_fog}};
static_assert(sizeof(EffectSet) == rows.size(), "an effect has no row here");

}  // namespace

std::vector<EffectReason> reasons_for_effects(const Scene& scene, const Layer& layer) {
  const EffectSet effects = effects_called_for(scene, layer);
  const bool is_surface = !is_projection(layer);
  std::vector<EffectReason> reasons;
  reasons.push_back({"transparency", is_surface && layer.material.opacity < 1,
                     is_surface ? concat("opacity is ", layer.material.opacity) : no_surface});
  reasons.push_back({"clipping", layer.clipped && scene.clip.has_value(), why_clipped(scene, layer)});
  for (const Row& row : rows) {
    const bool is_of_light = row.called_for != &EffectSet::intensity && row.called_for != &EffectSet::true_colors;
    const bool is_told = is_surface || !is_of_light;
    const bool is_lit = !is_unlit_slice(layer) || !is_of_light || effects.*row.called_for;
    reasons.push_back({row.effect, effects.*row.called_for,
                       !is_told  ? no_surface
                       : !is_lit ? not_lit
                                 : row.why(scene, layer)});
  }
  return reasons;
}

std::string_view machine_for(const Dataset& dataset, const Layer& layer, const FrameOptions& options) {
  const Machine machine = options.machine.value_or(chosen_machine());
  if (layer.mode == Mode::slice) return name_of(machine);
  const auto kernel = is_projection(layer) ? &Intersectors::largest : &Intersectors::first_hit;
  const bool is_wide = options.use_hierarchy && answers_wide(dataset.implementation(), layer.method, kernel, machine);
  return name_of(is_wide ? machine : Machine::scalar);
}

}  // namespace rhoray::render
