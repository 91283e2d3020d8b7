#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/rhoray/scene/values.h"

namespace rhoray::tools {

// What may stand in a scene document: one table for each kind of object. Reading, writing, the published schema and the
// reference are all made from these rows. A new key is a row here and a member in wishes.h.

const std::vector<Row<SceneWishes>>& scene_rows();
const std::vector<Row<DataWish>>& data_rows();
const std::vector<Row<OcclusionWish>>& occlusion_rows();
const std::vector<Row<FogWish>>& fog_rows();
const std::vector<Row<EffectsWish>>& effect_rows();
const std::vector<Row<CameraWish>>& camera_rows();
const std::vector<Row<KeyframeWish>>& keyframe_rows();
const std::vector<Row<ImageWish>>& image_rows();
const std::vector<Row<AxesWish>>& axes_rows();
const std::vector<Row<ColorBarWish>>& color_bar_rows();
const std::vector<Row<AnnotationsWish>>& annotation_rows();

/// A type of layer or light, its word in documents, and what may be said about it.
template <class Object>
struct Kind {
  decltype(Object::type) type;
  const char* word;
  const char* help;
  std::vector<Row<Object>> rows;
};
using LayerKind = Kind<LayerWish>;
using LightKind = Kind<LightWish>;

std::span<const LayerKind> layer_kinds();
std::span<const LightKind> light_kinds();

template <class Object>
const Kind<Object>& kind_of(decltype(Object::type) type, std::span<const Kind<Object>> kinds) {
  return *std::find_if(kinds.begin(), kinds.end(), [&](const Kind<Object>& kind) { return kind.type == type; });
}

}  // namespace rhoray::tools
