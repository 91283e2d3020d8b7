#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/scene_spec.h"
#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

// Options that take planes or boxes of the world.

/// The rows of the options that set the clip region.
std::vector<Option> clip_options(std::optional<render::ClipSpec>& spec);

/// The row of the option that adds slices.
Option slice_option(std::vector<render::LayerSpec>& slices);

/// The words of these options for a region.
std::vector<std::string> clip_words(const render::ClipSpec& spec);

}  // namespace rhoray::tools
