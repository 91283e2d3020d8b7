#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

tools::Subcommand secondary_rays();

}  // namespace rhoray::study
