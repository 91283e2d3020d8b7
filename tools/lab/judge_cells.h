#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Compares methods for the first crossing in a trilinear cell with exact arithmetic.
tools::Subcommand judge_cells();

}  // namespace rhoray::study
