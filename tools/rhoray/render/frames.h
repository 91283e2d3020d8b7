#pragma once

#include "render/scene_spec.h"
#include "tools/rhoray/render/command.h"

namespace rhoray::tools {

/// Draws a scene whose camera or isovalue has key frames: numbered pictures, one of them, or one
/// sheet of all; or says what is asked about it instead.
void run_frames(const RenderCommand& command, const render::SceneSpec& scene_spec);

}  // namespace rhoray::tools
