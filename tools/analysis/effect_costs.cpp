#include "tools/analysis/effect_costs.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "render/called_for.h"

namespace rhoray::tools {

namespace {

using render::Layer;
using render::Mode;
using render::ResolvedScene;

template <class Change>
void change_layers(ResolvedScene& plan, const Change& change) {
  for (Layer& layer : plan.scene.layers) change(layer);
}

void leave_out_antialiasing(ResolvedScene& plan) {
  plan.frame.antialiasing = 1;
}
void leave_out_shadows(ResolvedScene& plan) {
  for (render::Light& light : plan.scene.lights) light.casts_shadows = false;
}
void leave_out_occlusion(ResolvedScene& plan) {
  plan.scene.occlusion.radius = 0;
}
void leave_out_transparency(ResolvedScene& plan) {
  change_layers(plan, [](Layer& layer) {
    if (layer.material.opacity > 0) layer.material.opacity = 1;
  });
}
void leave_out_clipping(ResolvedScene& plan) {
  plan.scene.clip.reset();
}
void leave_out_smooth_normals(ResolvedScene& plan) {
  change_layers(plan, [](Layer& layer) { layer.material.normals = render::Normals::exact; });
}
/// Slices keep their colours: they show nothing else.
void leave_out_field_colors(ResolvedScene& plan) {
  change_layers(plan, [](Layer& layer) {
    if (layer.mode != Mode::slice) layer.material.color_by.reset();
  });
}
void leave_out_textures(ResolvedScene& plan) {
  change_layers(plan, [](Layer& layer) { layer.material.texture.reset(); });
}
void leave_out_highlights(ResolvedScene& plan) {
  change_layers(plan, [](Layer& layer) { layer.material.specular = 0; });
}
void leave_out_fog(ResolvedScene& plan) {
  plan.scene.fog.reset();
}

struct Row {
  std::string_view effect;  ///< as in render::reasons_for_effects, but for antialiasing
  void (*leave_out)(ResolvedScene& plan);
};

constexpr std::array rows{Row{"antialiasing", leave_out_antialiasing},
                          Row{"shadows", leave_out_shadows},
                          Row{"ambient occlusion", leave_out_occlusion},
                          Row{"transparency", leave_out_transparency},
                          Row{"clipping", leave_out_clipping},
                          Row{"smooth normals", leave_out_smooth_normals},
                          Row{"colour by field", leave_out_field_colors},
                          Row{"texture", leave_out_textures},
                          Row{"specular", leave_out_highlights},
                          Row{"fog", leave_out_fog}};

/// The number of layers that use an effect.
auto users_of(const ResolvedScene& plan, std::string_view effect) {
  if (effect == "antialiasing") return plan.frame.antialiasing > 1 ? std::ssize(plan.scene.layers) : 0;
  return std::count_if(plan.scene.layers.begin(), plan.scene.layers.end(), [&](const Layer& layer) {
    const auto reasons = render::reasons_for_effects(plan.scene, layer);
    return std::any_of(reasons.begin(), reasons.end(), [&](const render::EffectReason& reason) {
      return reason.effect == effect && reason.called_for;
    });
  });
}

}  // namespace

std::vector<WithoutEffect> without_each_effect(const ResolvedScene& plan) {
  std::vector<WithoutEffect> without;
  for (const Row& row : rows) {
    const auto users = users_of(plan, row.effect);
    if (users == 0) continue;
    WithoutEffect other{row.effect, plan};
    row.leave_out(other.plan);
    if (users_of(other.plan, row.effect) < users) without.push_back(std::move(other));
  }
  return without;
}

EffectTimes::EffectTimes(const ResolvedScene& plan) : variants_(without_each_effect(plan)) {
  variants_.insert(variants_.begin(), {"", plan});
  least_ms_.resize(variants_.size(), std::numeric_limits<double>::infinity());
}

void EffectTimes::took(double ms) {
  double& least = least_ms_[next_++ % variants_.size()];
  least = std::min(least, ms);
}

std::vector<EffectTimes::Cost> EffectTimes::costs() const {
  std::vector<Cost> costs;
  for (std::size_t i = 1; i < variants_.size(); ++i)
    costs.push_back({variants_[i].effect, least_ms_[0] - least_ms_[i]});
  return costs;
}

}  // namespace rhoray::tools
