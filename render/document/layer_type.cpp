#include "render/document/layer_type.h"

#include <tuple>

#include "formats/base/error.h"
#include "render/document/layer_data.h"
#include "render/document/values.h"
#include "render/method_words.h"

namespace rhoray::render {

namespace {

/// Refuses levels that do not exist for triangles.
void require_level_of_triangles(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset) {
  const std::string accuracy = accuracy_of(scene_spec, layer);
  if (!accuracy.empty() && !is_level_of_triangles(accuracy))
    throw Error(ErrorCode::usage,
                concat(given_as(scene_spec, "--accuracy", "accuracy"), ": found '", accuracy,
                       "'; expected float or double for ", dataset.has_fields() ? "the boundary of " : "",
                       dataset.file().name(), dataset.has_fields() ? "" : ", which holds triangles"));
}

}  // namespace

bool is_level_of_triangles(const std::string& accuracy) {
  return accuracy == "float" || accuracy == "double";
}

std::string accuracy_of(const SceneSpec& scene_spec, const LayerSpec& layer) {
  if (!layer.accuracy.empty()) return layer.accuracy;
  // On a command line a boundary is the layer that the level was asked for.
  const bool is_of_triangles =
      layer.type == LayerType::triangles || (layer.type == LayerType::boundary && !scene_spec.document.empty());
  return !is_of_triangles || is_level_of_triangles(scene_spec.accuracy) ? scene_spec.accuracy : "";
}

LayerType type_of(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset) {
  if (layer.type != LayerType::automatic) return layer.type;
  const std::string accuracy = accuracy_of(scene_spec, layer);
  // Methods of isosurfaces do not trace triangles.
  const bool asks_for_isosurface = layer.isovalues != LayerSpec{}.isovalues || !layer.method.empty() ||
                                   layer.context.value_or(0) > 0 ||
                                   (!accuracy.empty() && !is_level_of_triangles(accuracy));
  return dataset.is_mesh() && !asks_for_isosurface ? LayerType::boundary : LayerType::isosurface;
}

Method choose_method(const SceneSpec& scene_spec, std::size_t index, Mode mode, const Dataset& dataset) {
  const LayerSpec& layer = scene_spec.layers[index];
  const Place place = layer_place(scene_spec, index).at("method");
  if (!layer.method.empty() && !layer.accuracy.empty())
    throw Error(ErrorCode::invalid, concat(place.text(), ": \"accuracy\" is also given; expected only one of the two"));
  if (!layer.method.empty())
    return at_place(Place{scene_spec.document, {}}, [&] {
      return scene_spec.document.empty() ? method_named(layer.method, mode, dataset.is_mesh())
                                         : method_named(layer.method, mode, dataset.is_mesh(), place.pointer);
    });
  const std::string accuracy = accuracy_of(scene_spec, layer);
  return accuracy.empty() ? default_method(dataset, mode) : method_of(accuracy_named(accuracy));
}

void refuse_words_of_fields(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& dataset) {
  for (const auto& [given, option, key] : {std::tuple{layer.isovalues != LayerSpec{}.isovalues, "--iso", "isovalue"},
                                           {layer.type == LayerType::mip, "--mode", "type"},
                                           {layer.type == LayerType::boundary, "--mode", "type"},
                                           {layer.type == LayerType::slice, "--slice", "type"},
                                           {!layer.color_by.empty(), "--color-by", "color_by"},
                                           {!layer.colormap.empty(), "--colormap", "colormap"},
                                           {layer.range.has_value(), "--range", "range"},
                                           {!layer.scale.empty(), "--color-scale", "scale"},
                                           {layer.levels.has_value(), "--levels", "levels"},
                                           {!layer.method.empty(), "--method", "method"}})
    if (given)
      throw Error(ErrorCode::usage, concat(given_as(scene_spec, option, key), ": needs a field, and ",
                                           dataset.file().name(), " holds only triangles"));
  require_level_of_triangles(scene_spec, layer, dataset);
}

void refuse_words_of_isosurfaces(const SceneSpec& scene_spec, const LayerSpec& layer, const Dataset& boundary) {
  for (const auto& [given, option, key] : {std::tuple{layer.isovalues != LayerSpec{}.isovalues, "--iso", "isovalue"},
                                           {!layer.method.empty(), "--method", "method"},
                                           {layer.context.value_or(0) > 0, "--context", "context"}})
    if (given)
      throw Error(ErrorCode::usage,
                  concat(given_as(scene_spec, option, key), ": needs an isosurface; a boundary has none"),
                  concat("leave it out, or use ", scene_spec.document.empty() ? "--mode iso" : "type \"isosurface\""));
  require_level_of_triangles(scene_spec, layer, boundary);
}

}  // namespace rhoray::render
