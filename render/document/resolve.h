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

/// The zoom of a camera that is fitted and has none: less than 1 with a box, which leaves room for
/// its numbers.
double default_zoom(const ResolvedScene& plan);

/// The camera alone.
/// @param middle  View::target of a camera that is fitted
void place_camera(const SceneSpec& scene_spec, const FindShown& find_shown, const std::optional<Vec3>& middle,
                  ResolvedScene& plan);

}  // namespace rhoray::render
