#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

tools::Subcommand secondary_rays();

}  // namespace rhoray::study
