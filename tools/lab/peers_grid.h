#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Isosurfaces and largest values of a grid by this renderer and by others, in one run.
tools::Subcommand peers_grid();

}  // namespace rhoray::study
