#pragma once

#include "tools/rhoray/render/command.h"
#include "tools/rhoray/scene/scene_spec.h"

namespace rhoray::tools {

/// Draws a scene whose camera or isovalue has key frames: numbered pictures, one of them, or one
/// sheet of all; or says what is asked about it instead.
void run_frames(const RenderCommand& command, const SceneSpec& scene_spec);

}  // namespace rhoray::tools
