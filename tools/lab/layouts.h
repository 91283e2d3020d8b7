#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// How samples lie in memory, and what that costs: the paper's Table 3 with rows of today.
tools::Subcommand layouts();

/// One picture of a packed grid, for whoever counts its instructions from outside.
tools::Subcommand one_frame();

}  // namespace rhoray::study
