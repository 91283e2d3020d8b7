#pragma once

#include "tools/rhoray/subcommand.h"

namespace rhoray::study {

tools::Subcommand mesh_scale();

}  // namespace rhoray::study
