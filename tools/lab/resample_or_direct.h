#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// What is lost and won when a mesh's field is resampled on a grid instead of being drawn from its tetrahedra.
tools::Subcommand resample_or_direct();

}  // namespace rhoray::study
