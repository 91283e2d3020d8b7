#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/document/values.h"

namespace rhoray::render {

// What may stand in a scene document: one table for each kind of object. Reading, writing, the
// published schema and the reference are all made from these rows. A new key is a row here and a
// member in scene_spec.h.

const std::vector<Row<SceneSpec>>& scene_rows();
const std::vector<Row<DataSpec>>& data_rows();
const std::vector<Row<OcclusionSpec>>& occlusion_rows();
const std::vector<Row<FogSpec>>& fog_rows();
const std::vector<Row<EffectsSpec>>& effect_rows();
const std::vector<Row<CameraSpec>>& camera_rows();
const std::vector<Row<KeyframeSpec>>& keyframe_rows();
const std::vector<Row<PictureSpec>>& image_rows();
const std::vector<Row<AxesSpec>>& axes_rows();
const std::vector<Row<ColorBarSpec>>& color_bar_rows();
const std::vector<Row<AnnotationsSpec>>& annotation_rows();

/// A type of layer or light, its word in documents, and what may be said about it.
template <class Object>
struct Kind {
  decltype(Object::type) type;
  const char* word;
  const char* help;
  std::vector<Row<Object>> rows;
};
using LayerKind = Kind<LayerSpec>;
using LightKind = Kind<LightSpec>;

std::span<const LayerKind> layer_kinds();
std::span<const LightKind> light_kinds();

template <class Object>
const Kind<Object>& kind_of(decltype(Object::type) type, std::span<const Kind<Object>> kinds) {
  return *std::find_if(kinds.begin(), kinds.end(), [&](const Kind<Object>& kind) { return kind.type == type; });
}

}  // namespace rhoray::render
