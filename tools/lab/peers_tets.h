#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

tools::Subcommand peers_tets();

}  // namespace rhoray::study
