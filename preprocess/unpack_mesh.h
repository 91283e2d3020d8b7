#pragma once

#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A packed mesh as a neutral one: points in world coordinates, fields at points, cell ids.
NeutralMesh unpack_mesh(const formats::TetMesh& packed);

}  // namespace rhoray::preprocess
