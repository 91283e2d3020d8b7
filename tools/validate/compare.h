#pragma once

#include "formats/base/affine.h"
#include "tools/validate/grid_field.h"
#include "tools/validate/report.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// What is asked of a comparison.
struct RayQuery {
  double isovalue = 0;
  std::uint64_t samples = 100'000;
  std::uint64_t seed = 1;
  double max_depth_error = 0;              ///< beyond a hit's own bound; 0 = the default of the kind
  std::vector<render::Ray> camera_rays{};  ///< of the picture, if one is wanted
};

/// What a comparison found, and the rays of the picture.
struct Comparison {
  Report report;
  Shots picture;
};

/// Compares a tracer with the isosurface extracted from the same tetrahedra (tet_surface.h). Where the two name the
/// same cell its crossing is computed exactly; where they differ the first crossing of all is (tet_judge.h), so that
/// what counts is the field, not the rounding of the extracted surface.
Comparison compare_tets(const TetField& field, const Affine& world_from_frame, const RayQuery& query,
                        const Tracer& tracer, const Thousandths& progress);

/// Compares a tracer with a trilinear field. Every hit is proved by two points before and behind it on different sides,
/// decided exactly (grid_judge.h), and its depth measured to the crossing between them; its distance from the surface
/// is at most that to a crossing along the field's gradient, proved in the same way. Every ray is probed for a crossing
/// that the tracer passed over. Beside that stands the surface that CGAL's surface mesher finds (grid_surface.h): where
/// shooting at it gives another answer the field is probed there closely; the distance to it is told together with its
/// own error.
Comparison compare_grid(const GridField& field, const Affine& world_from_frame, const RayQuery& query,
                        const Tracer& tracer, const Thousandths& progress);

}  // namespace rhoray::tools::validate
