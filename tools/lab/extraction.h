#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// The paper's Table 6: isosurfaces of a grid as triangles, compared with drawing them directly.
tools::Subcommand extraction();

}  // namespace rhoray::study
