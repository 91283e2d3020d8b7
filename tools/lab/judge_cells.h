#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// Methods for the first crossing in a trilinear cell against the exact judge.
tools::Subcommand judge_cells();

}  // namespace rhoray::study
