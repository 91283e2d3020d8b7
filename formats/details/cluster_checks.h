#pragma once

#include "formats/details/deep_checks.h"
#include "formats/tet_mesh.h"

namespace rhoray::formats::details {

/// The checks of clusters in deep_findings beyond check_ranges: each table must be increasing and
/// hold exactly the vertices of its cells.
void check_clusters(const TetMesh& mesh, Findings& findings);

}  // namespace rhoray::formats::details
