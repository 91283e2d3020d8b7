#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Studies the cost of memory layouts of samples: the paper's Table 3 with rows for today's
/// systems.
tools::Subcommand layouts();

/// Draws one picture of a packed grid, so that its instructions can be counted from outside.
tools::Subcommand one_frame();

}  // namespace rhoray::study
