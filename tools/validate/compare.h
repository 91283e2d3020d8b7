#pragma once

#include "formats/base/affine.h"
#include "tools/validate/report.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// Compares a tracer with the isosurface extracted from the same tetrahedra (tet_surface.h). Where the two name the
/// same cell its crossing is computed exactly; where they differ the first crossing of all is (tet_judge.h), so that
/// what counts is the field, not the rounding of the extracted surface.
Comparison compare_tets(const TetField& field, const Affine& world_from_frame, const Question& question,
                        const Tracer& tracer, const Thousandths& progress);

}  // namespace rhoray::tools::validate
