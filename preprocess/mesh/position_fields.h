#pragma once

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// True when some field, at points or in cells, has two different finite values in one component.
/// Cell fields "region", "block", "physical" and "entity" do not count: their numbers name parts
/// and do not describe their shape.
bool has_varying_field(const NeutralMesh& mesh);

/// Adds fields to a mesh that has none, so that its shape can be shown:
///  * "boundary_distance": the distance of each point from the nearest face of the boundary (in the
///    mesh's unit; a small isovalue shows the shape);
///  * "interior": 0 at points of the boundary and 1 inside;
///  * the coordinates "x", "y" and "z".
///
/// Where no face belongs to one cell alone, only the coordinates are added. The new fields come
/// before the existing ones. Cells whose corners all lie on the boundary are cut in four at their
/// centre; otherwise boundary_distance would be 0 throughout them. cell_ids tell which cells they
/// came from. Expects vertex numbers below the number of points.
void add_position_fields(NeutralMesh& mesh);

}  // namespace rhoray::preprocess
