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
const std::vector<Row<CameraWish>>& camera_rows();
const std::vector<Row<ImageWish>>& image_rows();

/// A type of layer, its word in documents, and what may be said about it.
struct LayerKind {
  LayerType type;
  const char* word;
  const char* help;
  std::vector<Row<LayerWish>> rows;
};
std::span<const LayerKind> layer_kinds();
const LayerKind& kind_of(LayerType type);

}  // namespace rhoray::tools
