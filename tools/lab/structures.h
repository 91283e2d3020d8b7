#pragma once

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::study {

/// Studies the cost of structures in which rays find tetrahedra. Compares leaf lists of several
/// resolutions with clusters of several sizes, on uniform, graded and sliver-rich meshes.
tools::Subcommand structures();

}  // namespace rhoray::study
