#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

tools::Subcommand mesh_scale();

}  // namespace rhoray::study
