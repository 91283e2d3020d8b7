#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// The largest value along rays through grids: compares every method with exact arithmetic.
tools::Subcommand largest_values();

}  // namespace rhoray::study
