#pragma once

#include <string>
#include <vector>

#include "tools/rhoray/report.h"
#include "tools/rhoray/scene/plan.h"

namespace rhoray::tools {

/// What a scene calls for and what not, by layer and effect, and why. What is told is asked of the functions that the
/// frame asks.
Json explained(const SceneWishes& wishes, const ScenePlan& plan);

/// The same as lines of text.
std::vector<std::string> explained_lines(const Json& explanation);

}  // namespace rhoray::tools
