#include "tools/rhoray/render/label_layers.h"

#include <algorithm>

#include "formats/base/text.h"
#include "formats/base/word_list.h"

namespace rhoray::tools {

namespace {

/// Whether nothing but the kind of data decides what the layer shows.
bool is_open(const render::LayerSpec& layer) {
  const render::LayerSpec defaults;
  return layer.type == render::LayerType::automatic && layer.visible && layer.isovalues == defaults.isovalues &&
         layer.method.empty() && layer.color_by.empty() && layer.texture.empty() && !layer.context;
}

/// The data of a layer; null where they are refused later, or are those of one label already.
const render::DataSpec* data_of(const render::LayerSpec& layer, const render::SceneSpec& scene_spec) {
  for (const render::DataSpec& each : scene_spec.data)
    if (each.name == layer.data || (layer.data.empty() && scene_spec.data.size() == 1))
      return each.label ? nullptr : &each;
  return nullptr;
}

std::string text_of(const Segmentation& segmentation) {
  std::vector<std::string> values;
  for (const preprocess::Label& label : segmentation.labels) values.push_back(concat(label.value));
  return concat("'", segmentation.grid.description().fields[segmentation.field].name,
                "' holds labels: ", joined(values),
                "; each gets a surface (--mode iso shows an isosurface of the numbers)");
}

}  // namespace

render::SceneSpec with_label_layers(render::SceneSpec scene_spec, const DataAccess& access) {
  std::vector<render::LayerSpec> layers;
  std::vector<render::DataSpec> data;
  for (const render::LayerSpec& layer : scene_spec.layers) {
    const render::DataSpec* of_layer = is_open(layer) ? data_of(layer, scene_spec) : nullptr;
    const auto segmentation = of_layer != nullptr ? segmentation_in(*of_layer, access) : std::nullopt;
    if (!segmentation) {
      layers.push_back(layer);
      continue;
    }
    if (access.say) access.say(text_of(*segmentation));
    for (const preprocess::Label& label : segmentation->labels) {
      render::DataSpec of_label = *of_layer;
      of_label.name = concat(of_layer->name, of_layer->name.empty() ? "" : " ", "label ", label.value);
      of_label.label = label.value;
      data.push_back(of_label);
      render::LayerSpec surface = layer;
      surface.type = render::LayerType::isosurface;
      surface.data = of_label.name;
      surface.isovalues = {"0.5"};
      layers.push_back(std::move(surface));
    }
  }
  if (data.empty()) return scene_spec;
  for (const render::DataSpec& each : scene_spec.data)
    if (std::any_of(layers.begin(), layers.end(),
                    [&](const auto& layer) { return layer.data == each.name || layer.texture == each.name; }))
      data.push_back(each);
  scene_spec.layers = std::move(layers), scene_spec.data = std::move(data);
  return scene_spec;
}

}  // namespace rhoray::tools
