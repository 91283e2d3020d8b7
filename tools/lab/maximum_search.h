#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// In which order to look for the largest value along rays through a grid: what each order has to look at.
tools::Subcommand maximum_search();

}  // namespace rhoray::study
