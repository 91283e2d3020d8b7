#include "render/document/feature_edges.h"

#include <memory>
#include <utility>

namespace rhoray::render {

bool is_plain_boundary(const ResolvedScene& plan, std::size_t layer) {
  const Layer& shown = plan.scene.layers[layer];
  const Material& material = shown.material;
  return shown.mode == Mode::triangles && plan.datasets[shown.dataset].has_fields() &&
         !plan.data[shown.dataset].label && !material.color_by && !material.texture && material.opacity >= 1;
}

void plan_feature_edges(const SceneSpec& scene_spec, ResolvedScene& plan) {
  constexpr double default_deg = 30, least_distance = 0.01;
  if (plan.page) return;
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    LayerOrigin& origin = plan.origins[i];
    const std::optional<double> asked = scene_spec.layers[origin.spec].feature_edges;
    const bool is_default = !asked && is_plain_boundary(plan, i);
    if (plan.scene.layers[i].mode != Mode::triangles || origin.is_context || !(asked || is_default)) continue;
    const double angle_deg = asked.value_or(default_deg);
    const Dataset& dataset = plan.datasets[plan.scene.layers[i].dataset];
    if (!(angle_deg < no_feature_edges)) continue;
    FeatureEdges found = dataset.feature_edges(angle_deg);
    if (is_default && found.mean_distance < least_distance * dataset.bounds().size().length()) continue;
    origin.feature_edges_deg = angle_deg;
    if (!found.edges.empty()) origin.lines = std::make_shared<const FeatureEdges>(std::move(found));
  }
}

}  // namespace rhoray::render
