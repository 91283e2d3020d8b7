#pragma once

#include <string>
#include <vector>

#include "tools/rhoray/report.h"
#include "tools/rhoray/scene/resolve.h"

namespace rhoray::tools {

/// What a scene needs and does not need, by layer and effect, and why. The answers come from the
/// functions that rendering uses.
Json explained(const SceneSpec& scene_spec, const ResolvedScene& plan);

/// The same as lines of text.
std::vector<std::string> explained_lines(const Json& explanation);

}  // namespace rhoray::tools
