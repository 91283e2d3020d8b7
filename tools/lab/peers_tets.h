#pragma once

#include "tools/rhoray/subcommand.h"

namespace rhoray::study {

tools::Subcommand peers_tets();

}  // namespace rhoray::study
