#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "render/document.h"
#include "render/document/lights.h"

namespace rhoray::render {

/// Returns what is shown. It is called only if a choice depends on it.
using FindShown = std::function<const Shown&()>;

/// aim_camera around what is known to be shown.
void aim_camera(const SceneSpec& scene_spec, const FindShown& find_shown, ResolvedScene& plan);

/// The camera alone.
/// @param target  of a camera that is fitted; nothing: such that what is shown lies in the middle
void place_camera(const SceneSpec& scene_spec, const FindShown& find_shown, const std::optional<Vec3>& target,
                  ResolvedScene& plan);

}  // namespace rhoray::render
