#pragma once

#include "tools/rhoray/subcommand.h"

namespace rhoray::study {

tools::Subcommand secondary_rays();

}  // namespace rhoray::study
