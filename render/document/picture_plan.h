#pragma once

#include "render/document.h"

namespace rhoray::render {

/// Chooses size, channels, antialiasing and background. The plan holds its layers already.
void plan_image(const SceneSpec& scene_spec, ResolvedScene& plan);

/// Replaces the annotations in the plan, which its layers need, by the requested ones, and keeps
/// those of the layers where the specification says nothing. Refuses annotations that have nothing
/// to show.
void plan_annotations(const SceneSpec& scene_spec, ResolvedScene& plan);

}  // namespace rhoray::render
