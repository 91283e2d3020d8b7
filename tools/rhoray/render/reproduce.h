#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/resolved_scene.h"

namespace rhoray::tools {

/// The command that makes this picture again, every choice spelled out: in options for a scene of
/// one layer under the lights of a style, else in a document on the command line.
std::vector<std::string> reproducing_command(const render::ResolvedScene& plan, const std::filesystem::path& output);

/// Whether options can say all layers: there is one, or an isosurface and the boundary around it.
bool is_of_one_layer(const render::ResolvedScene& plan);

}  // namespace rhoray::tools
