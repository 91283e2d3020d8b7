#pragma once

#include "tools/rhoray/command_line.h"

namespace rhoray::study {

/// How rays find tetrahedra, and what that costs: leaf lists of several resolutions beside clusters of several sizes,
/// on uniform, graded and sliver-rich meshes.
tools::Subcommand structures();

}  // namespace rhoray::study
