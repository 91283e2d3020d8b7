#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/rhoray/scene/resolve.h"
#include "tools/rhoray/scene/scene_spec.h"

namespace rhoray::tools {

/// Wishes that say every choice of the plan, so that they are planned to the same picture.
SceneSpec to_spec(const ResolvedScene& plan);

/// The command that makes this picture again, every choice spelled out: in options for a scene of
/// one layer under one white light at the eye, else in a document on the command line.
std::vector<std::string> reproducing_command(const ResolvedScene& plan, const std::filesystem::path& output);

}  // namespace rhoray::tools
