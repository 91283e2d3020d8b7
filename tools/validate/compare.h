#pragma once

#include "formats/base/affine.h"
#include "tools/validate/grid_field.h"
#include "tools/validate/report.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// Compares a tracer with the isosurface extracted from the same tetrahedra (tet_surface.h). Where the two name the
/// same cell its crossing is computed exactly; where they differ the first crossing of all is (tet_judge.h), so that
/// what counts is the field, not the rounding of the extracted surface.
Comparison compare_tets(const TetField& field, const Affine& world_from_frame, const Question& question,
                        const Tracer& tracer, const Thousandths& progress);

/// Compares a tracer with a trilinear field. Every hit is proved by two points before and behind it on different sides,
/// decided exactly (grid_judge.h), and its depth measured to the crossing between them; every ray is probed for a
/// crossing that the tracer passed over. Beside that stands the surface that CGAL's surface mesher finds
/// (grid_surface.h): distances both ways are told together with the mesh's own error, and where shooting at the mesh
/// gives another answer the field is probed there closely.
Comparison compare_grid(const GridField& field, const Affine& world_from_frame, const Question& question,
                        const Tracer& tracer, const Thousandths& progress);

}  // namespace rhoray::tools::validate
