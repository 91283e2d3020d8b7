#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Studies the search order for the largest value along rays through a grid: the work that each
/// order needs.
tools::Subcommand maximum_search();

}  // namespace rhoray::study
