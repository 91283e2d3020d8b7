#pragma once

#include "formats/base/progress.h"
#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Converts a packed mesh into a neutral one: points in world coordinates, fields, cell ids. Points
/// are in the source's order. Cells are ordered by their ids, so those cut from one cell are
/// consecutive.
NeutralMesh unpack_mesh(const formats::TetMesh& packed, const Watch& watch = {});

}  // namespace rhoray::preprocess
