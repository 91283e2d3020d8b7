#pragma once

#include "formats/details/deep_checks.h"
#include "formats/tet_mesh.h"

namespace rhoray::formats::details {

/// What deep_findings asks of clusters beside check_ranges: tables that rise and hold the vertices
/// of their cells and no others.
void check_clusters(const TetMesh& mesh, Findings& findings);

}  // namespace rhoray::formats::details
