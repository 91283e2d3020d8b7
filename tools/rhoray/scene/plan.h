#pragma once

#include <functional>

#include "tools/rhoray/scene/lights.h"
#include "tools/rhoray/scene/scene_plan.h"
#include "tools/rhoray/scene/wishes.h"

namespace rhoray::tools {

using OpenData = std::function<render::Volume(const DataWish&)>;

/// Opens the data of visible layers and chooses what is shown of them; all but the camera. An isovalue outside its
/// field's range is left out with a note where anything else is shown. Refuses what does not go together: of a document
/// with the JSON pointer (Trouble::invalid), of a command line with the option (Trouble::usage).
ScenePlan plan_layers(const SceneWishes& wishes, const OpenData& open);

/// The same, with data opened by load_volume.
ScenePlan plan_layers(const SceneWishes& wishes);

/// Points the camera: where it is not said, so that all that is shown is seen. Then places what depends on it: lights,
/// ambient occlusion, fog. Looks at every cell of a mesh where any of these is fitted to what is shown.
void aim_camera(const SceneWishes& wishes, ScenePlan& plan);

/// The same, around what is known to be shown.
void aim_camera(const SceneWishes& wishes, const ShownBox& shown, ScenePlan& plan);

/// The camera alone.
void place_camera(const SceneWishes& wishes, const ShownBox& shown, ScenePlan& plan);

/// Around all that is shown; around the data where no surface passes through any cell.
Box3 shown_box(const ScenePlan& plan);

}  // namespace rhoray::tools
