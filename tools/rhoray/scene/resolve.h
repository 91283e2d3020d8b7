#pragma once

#include <functional>

#include "tools/rhoray/scene/lights.h"
#include "tools/rhoray/scene/resolved_scene.h"
#include "tools/rhoray/scene/scene_spec.h"

namespace rhoray::tools {

using OpenData = std::function<render::Volume(const DataSpec&)>;

/// Opens the data of visible layers and resolves everything but the camera. A layer whose isovalue
/// is outside its field's range is left out with a note if anything else is shown. Refuses
/// conflicts: in a document with the JSON pointer (ErrorCode::invalid), on a command line with the
/// option (ErrorCode::usage).
ResolvedScene resolve_layers(const SceneSpec& scene_spec, const OpenData& open);

/// The same, with data opened by load_volume.
ResolvedScene resolve_layers(const SceneSpec& scene_spec);

/// Points the camera: where it is not said, so that all that is shown is seen. Then places what
/// depends on it: lights, ambient occlusion, fog. CandidateList at every cell of a mesh where any
/// of these is fitted to what is shown.
void aim_camera(const SceneSpec& scene_spec, ResolvedScene& plan);

/// The same, around what is known to be shown.
void aim_camera(const SceneSpec& scene_spec, const ShownBox& shown, ResolvedScene& plan);

/// The camera alone.
void place_camera(const SceneSpec& scene_spec, const ShownBox& shown, ResolvedScene& plan);

/// Around all that is shown; around the data where no surface passes through any cell.
Box3 shown_box(const ResolvedScene& plan);

}  // namespace rhoray::tools
