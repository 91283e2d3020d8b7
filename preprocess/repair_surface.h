#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct RepairOptions {
  /// When above 0, wrap instead of mending: make a new closed surface around the old one, from
  /// outside. It bridges gaps narrower than this fraction of the box diagonal (CGAL's alpha
  /// wrapping).
  double wrap = 0;
  bool largest_part_only = false;  ///< keep only the connected part with the largest area
  /// Mending that moves the surface farther (RepairReport::moved) is refused. A fraction of the box
  /// diagonal.
  double max_move = 0.02;
  std::uint64_t memory_limit_bytes = std::uint64_t{8} << 30;  ///< of the worker
  double time_limit_s = 300;                                  ///< CPU seconds of the worker
};

/// What was done, and how far it moved the surface. Lengths are in the surface's units.
struct RepairReport {
  std::uint64_t merged_points = 0;       ///< points with the coordinates of another
  std::uint64_t dropped_flat = 0;        ///< facets without area
  std::uint64_t dropped_twins = 0;       ///< duplicate facets
  std::uint64_t dropped_not_finite = 0;  ///< facets with a coordinate that is not finite
  /// points duplicated where sheets met in one point or in an edge of more than two facets
  std::uint64_t split_points = 0;
  std::uint64_t stitched_edges = 0;  ///< pairs of open edges that coincided
  std::uint64_t filled_holes = 0;
  std::uint64_t crossing_pairs = 0;  ///< of facets, after all the steps above
  std::uint64_t mended_parts = 0;    ///< parts whose facets crossed each other and were replaced
  /// closed parts that crossed others and became one solid with them
  std::uint64_t united_parts = 0;
  std::uint64_t dropped_parts = 0;
  bool wrapped = false;
  /// How far replacing crossing facets and removing needles moved the surface. For each of the two
  /// steps it is the larger of the two one-sided Hausdorff distances; the two are added. Facets
  /// that fill holes, that are dropped on request, or that lie inside once closed parts are united
  /// do not count. 0 when wrapped.
  double moved = 0;
  /// one-sided Hausdorff distance, from the new surface to the old
  double farthest_new_from_old = 0;
  double farthest_old_from_new = 0;  ///< from the old surface to the new
  double distance_error = 0;         ///< the true distances differ from these by at most this
  double box_diagonal = 0;           ///< of the old surface
};

struct RepairedSurface {
  NeutralSurface surface;  ///< triangles; its notes describe in sentences what was done
  RepairReport report;
};

/// Mends a surface (CGAL's polygon mesh processing, in a worker process with limits). It cuts
/// facets of more than three corners, and faces with openings, into triangles. It merges duplicate
/// points and facets, drops facets without area, separates sheets at edges of more than two facets,
/// orients, stitches and fills holes. It replaces facets that cross and unites closed parts that
/// cross each other. Seeds of holes and regions are kept; target sizes are not. Solids may still
/// touch in edges and points. A repair that moves the surface farther than `max_move` is refused.
/// Success is not promised: `find_faults` (inspect_surface.h) finds the remaining faults, and
/// `tetrahedralize` refuses them.
RepairedSurface repair_surface(const NeutralSurface& surface, const RepairOptions& options = {});

}  // namespace rhoray::preprocess
