#pragma once

#include "render/document.h"
#include "render/document/lights.h"

namespace rhoray::render {

/// aim_camera around what is known to be shown.
void aim_camera(const SceneSpec& scene_spec, const ShownBox& shown, ResolvedScene& plan);

/// The camera alone.
void place_camera(const SceneSpec& scene_spec, const ShownBox& shown, ResolvedScene& plan);

/// Around all that is shown; around the data where no surface passes through any cell.
Box3 shown_box(const ResolvedScene& plan);

}  // namespace rhoray::render
