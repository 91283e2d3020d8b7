#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Studies the benefits and losses of resampling a mesh's field on a grid instead of drawing its
/// tetrahedra.
tools::Subcommand resample_or_direct();

}  // namespace rhoray::study
