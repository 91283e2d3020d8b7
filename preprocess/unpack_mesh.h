#pragma once

#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A packed mesh as a neutral one: points in world coordinates, fields at points, cell ids. Points stand in the
/// source's order, cells by their ids: those that were cut from one cell side by side.
NeutralMesh unpack_mesh(const formats::TetMesh& packed);

}  // namespace rhoray::preprocess
