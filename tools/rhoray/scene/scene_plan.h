#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "render/heat_map.h"
#include "render/load.h"
#include "render/render.h"
#include "tools/rhoray/scene/wishes.h"

namespace rhoray::tools {

/// Where a layer of the planned scene comes from.
struct LayerOrigin {
  std::size_t wish = 0;       ///< index into SceneWishes::layers
  std::string isovalue_from;  ///< "given", "percentile 95", "Otsu's threshold"; empty for MIP
};

/// Everything that was chosen.
struct ScenePlan {
  std::vector<render::Volume> volumes;
  std::vector<DataWish> data;  ///< of each volume, with the name of its field
  std::vector<render::Texture> textures;
  std::vector<DataWish> texture_data;  ///< of each texture
  render::Scene scene;
  std::vector<LayerOrigin> origins;  ///< of each layer
  render::FrameOptions frame;
  std::optional<render::DiaryPage> page;  ///< drawn instead of colours
  AnnotationsWish annotations;
  Box3 annotated_box;              ///< around what is shown, where annotations ask for it
  std::vector<std::string> notes;  ///< what was left out or chosen otherwise than asked, one line each
};

}  // namespace rhoray::tools
