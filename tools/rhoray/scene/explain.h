#pragma once

#include <string>
#include <vector>

#include "tools/rhoray/report.h"
#include "tools/rhoray/scene/resolve.h"

namespace rhoray::tools {

/// What a scene calls for and what not, by layer and effect, and why. What is told is asked of the functions that the
/// frame asks.
Json explained(const SceneSpec& scene_spec, const ResolvedScene& plan);

/// The same as lines of text.
std::vector<std::string> explained_lines(const Json& explanation);

}  // namespace rhoray::tools
