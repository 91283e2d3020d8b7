#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

tools::Subcommand peers_tets();

}  // namespace rhoray::study
