#pragma once

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// True when some field, at points or in cells, has two different finite values in one component. Cell
/// fields "region", "block", "physical" and "entity" do not count: their numbers name parts, and say nothing of their
/// shape.
bool has_varying_field(const NeutralMesh& mesh);

/// Fields for a mesh that brings none, so that its shape can be seen: "boundary_distance", how far each point lies from
/// the nearest face of the boundary (in the mesh's unit; a small isovalue shows the shape), "interior", 0 at points of
/// the boundary and 1 inside, and the coordinates "x", "y" and "z"; the coordinates alone where no face is a cell's
/// own. They come before the fields that are there. Cells whose corners all lie on the boundary are cut in four at
/// their middle, or boundary_distance would be 0 all through them; cell_ids tell which they were. Expects vertex
/// numbers below the number of points.
void add_position_fields(NeutralMesh& mesh);

}  // namespace rhoray::preprocess
