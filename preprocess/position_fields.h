#pragma once

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// True when some field, at points or in cells, has two different finite values in one component.
bool has_varying_field(const NeutralMesh& mesh);

/// Fields for a mesh that brings none, so that its shape can be seen: "interior", 0 at points of the boundary and 1
/// inside, when there are both (its isosurface 0.5 runs through the outermost layer of cells), and the coordinates "x",
/// "y" and "z". They come before those that are there. Expects vertex numbers below the number of points.
void add_position_fields(NeutralMesh& mesh);

}  // namespace rhoray::preprocess
