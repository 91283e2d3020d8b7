#pragma once

#include "preprocess/neutral.h"
#include "preprocess/tetrahedralize.h"

namespace rhoray::preprocess {

/// Runs TetGen on a checked surface (surface_checks.h). TetGen's codes become Errors in our words,
/// with the facets it names. May still end the process (assertions inside TetGen); never run it in
/// a process that must live.
NeutralMesh fill(NeutralSurface surface, const TetrahedralizeOptions& options);

}  // namespace rhoray::preprocess
