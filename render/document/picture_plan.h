#pragma once

#include "render/document.h"

namespace rhoray::render {

/// Chooses size, channels, antialiasing and background. The plan holds its layers already.
void plan_image(const SceneSpec& scene_spec, ResolvedScene& plan);

/// Replaces the annotations in the plan by the requested ones. An annotation that a layer needs
/// stays if the specification does not mention it. Refuses annotations that have nothing to show.
void plan_annotations(const SceneSpec& scene_spec, ResolvedScene& plan);

}  // namespace rhoray::render
