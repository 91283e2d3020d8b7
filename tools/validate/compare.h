#pragma once

#include "formats/base/affine.h"
#include "tools/validate/grid_field.h"
#include "tools/validate/report.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// Parameters of a comparison.
struct RayQuery {
  double isovalue = 0;
  std::uint64_t samples = 100'000;
  std::uint64_t seed = 1;
  /// In addition to a hit's own bound; 0: the default of the kind.
  double max_depth_error = 0;
  std::vector<render::Ray> camera_rays{};  ///< of the picture, if one is requested
};

/// Result of a comparison, and the rays of the picture.
struct Comparison {
  Report report;
  Shots picture;
};

/// Compares a tracer with the isosurface extracted from the same tetrahedra (tet_surface.h). Where
/// both report the same cell, its crossing is computed exactly. Where they differ, the first
/// crossing of all cells is computed (tet_judge.h). So the field decides, not the rounding of the
/// extracted surface.
Comparison compare_tets(const TetField& field, const Affine& world_from_frame, const RayQuery& query,
                        const Tracer& tracer, const Thousandths& progress);

/// Compares a tracer with a trilinear field. Every hit is proved by two points before and behind it
/// on different sides of the isovalue, decided exactly (grid_judge.h). Its depth error is measured
/// to the crossing between them. Its distance from the surface is at most that to a crossing along
/// the field's gradient, proved in the same way. Every ray is probed for a crossing that the tracer
/// missed.
///
/// The result is also compared with the surface from CGAL's surface mesher (grid_surface.h). Where
/// a ray hits that surface at a different position, the field is probed closely there. The distance
/// to it is reported together with its own error.
Comparison compare_grid(const GridField& field, const Affine& world_from_frame, const RayQuery& query,
                        const Tracer& tracer, const Thousandths& progress);

}  // namespace rhoray::tools::validate
