#pragma once

#include <filesystem>
#include <vector>

#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/render/picture_options.h"

namespace rhoray::tools {

/// The scene that inputs and options ask for: a document, alone or in a picture, with the options
/// on top; or files and options alone. Says the document's warnings.
render::SceneSpec asked_scene(const PictureOptions& picture, const std::vector<std::filesystem::path>& inputs,
                              const CommonOptions& common);

}  // namespace rhoray::tools
