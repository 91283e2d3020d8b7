#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// The largest value along rays through grids: every method against the exact judge.
tools::Subcommand largest_values();

}  // namespace rhoray::study
