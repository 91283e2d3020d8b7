#pragma once

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// True when some field, at points or in cells, has two different finite values in one component. Cell
/// field "region" does not count: its numbers name parts, and say nothing of their shape.
bool has_varying_field(const NeutralMesh& mesh);

/// Fields for a mesh that brings none, so that its shape can be seen: where there are points inside,
/// "boundary_distance", how far each point lies from the nearest face of the boundary (in the mesh's unit; a small
/// isovalue shows the shape), and "interior", 0 at points of the boundary and 1 inside; and the coordinates "x", "y"
/// and "z", which come first for a mesh whose points all lie on the boundary. They come before those that are there.
/// Expects vertex numbers below the number of points.
void add_position_fields(NeutralMesh& mesh);

}  // namespace rhoray::preprocess
