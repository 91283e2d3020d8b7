#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

tools::Subcommand mesh_scale();

}  // namespace rhoray::study
