#pragma once

#include <vector>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// The options of a picture, each with those that it replaces when it is given later, so that a
/// printed command can be changed by adding to it.
std::vector<Option> with_replacements(std::vector<Option> options);

}  // namespace rhoray::tools
