#include "tools/rhoray/render/label_layers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

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

/// Whether a level is one of isosurfaces only.
bool is_of_isosurfaces(const std::string& accuracy) {
  return !accuracy.empty() && accuracy != "float" && accuracy != "double";
}

/// The labels of a layer's data.
struct FoundLabels {
  std::string field;
  bool are_of_cells = false;
  std::vector<preprocess::CellLabel> labels;  ///< of a grid: none hides another
  formats::LabelNames names;
};

/// Nothing where the data hold no labels.
std::optional<FoundLabels> labels_in(const render::DataSpec& data, const DataAccess& access) {
  if (const std::optional<Segmentation> grid = segmentation_in(data, access)) {
    const formats::FieldSummary& field = grid->grid.description().fields[grid->field];
    FoundLabels found{.field = field.name, .labels = {}, .names = field.label_names};
    for (const preprocess::Label& label : grid->labels) found.labels.push_back({.value = label.value});
    return found;
  }
  if (std::optional<Regions> mesh = regions_in(data, access))
    return FoundLabels{
        .field = mesh->field, .are_of_cells = true, .labels = std::move(mesh->labels), .names = std::move(mesh->names)};
  return std::nullopt;
}

std::string text_of(const FoundLabels& found) {
  std::vector<std::string> values;
  for (const preprocess::CellLabel& label : found.labels) {
    const auto name = found.names.find(label.value);
    values.push_back(name == found.names.end() ? concat(label.value) : concat(label.value, " (", name->second, ")"));
  }
  return concat("'", found.field, "' holds labels: ", joined(values), "; each gets a surface (",
                found.are_of_cells ? concat("--color-by ", found.field, " colours the outside")
                                   : "--mode iso shows an isosurface of the numbers",
                ")");
}

/// The layer that shows a label. One that hides k others, each inside the one before, has opacity
/// 1/(k + 2), as the outermost of k + 1 isosurfaces.
render::LayerSpec surface_of(const preprocess::CellLabel& label, bool is_of_cells, render::LayerSpec layer) {
  layer.type = is_of_cells ? render::LayerType::boundary : render::LayerType::isosurface;
  if (!is_of_cells) layer.isovalues = {"0.5"};
  if (label.hidden_count > 0 && !layer.opacity)
    layer.opacity = std::round(100.0 / static_cast<double>(label.hidden_count + 2)) / 100;
  return layer;
}

}  // namespace

render::SceneSpec with_label_layers(render::SceneSpec scene_spec, const DataAccess& access) {
  std::vector<render::LayerSpec> layers;
  std::vector<render::DataSpec> data;
  for (const render::LayerSpec& layer : scene_spec.layers) {
    const render::DataSpec* of_layer = is_open(layer) ? data_of(layer, scene_spec) : nullptr;
    const auto found = of_layer != nullptr ? labels_in(*of_layer, access) : std::nullopt;
    const bool needs_isosurface = is_of_isosurfaces(layer.accuracy.empty() ? scene_spec.accuracy : layer.accuracy);
    if (!found || (found->are_of_cells && needs_isosurface)) {
      layers.push_back(layer);
      continue;
    }
    if (access.say) access.say(text_of(*found));
    for (const preprocess::CellLabel& label : found->labels) {
      render::DataSpec of_label = *of_layer;
      of_label.name = concat(of_layer->name, of_layer->name.empty() ? "" : " ", "label ", label.value);
      of_label.label = label.value;
      if (found->are_of_cells) of_label.field = found->field;
      data.push_back(of_label);
      layers.push_back(surface_of(label, found->are_of_cells, layer));
      layers.back().data = of_label.name;
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
