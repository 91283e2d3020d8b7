#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct RepairOptions {
  /// When above 0: do not mend but wrap: a new closed surface around the old one, from outside, that bridges gaps
  /// narrower than this share of the box diagonal (CGAL's alpha wrapping).
  double wrap = 0;
  bool largest_part_only = false;  ///< of the connected parts, the one with the largest area
  /// Mending that moves the surface farther (RepairReport::moved) is refused: a share of the box diagonal.
  double max_move = 0.02;
  std::uint64_t memory_limit_bytes = std::uint64_t{8} << 30;  ///< of the worker
  double time_limit_s = 300;                                  ///< CPU seconds of the worker
};

/// What was done, and how far it moved the surface. Lengths are in the surface's units.
struct RepairReport {
  std::uint64_t merged_points = 0;       ///< had the coordinates of another
  std::uint64_t dropped_flat = 0;        ///< facets without area
  std::uint64_t dropped_twins = 0;       ///< facets that were there twice
  std::uint64_t dropped_not_finite = 0;  ///< facets with a coordinate that is not finite
  std::uint64_t split_points = 0;    ///< doubled where sheets met in one point or in an edge of more than two facets
  std::uint64_t stitched_edges = 0;  ///< pairs of open edges that lay on each other
  std::uint64_t filled_holes = 0;
  std::uint64_t crossing_pairs = 0;  ///< of facets, when all the above was done
  std::uint64_t mended_parts = 0;    ///< whose facets crossed each other and were replaced
  std::uint64_t united_parts = 0;    ///< closed parts that crossed others and became one solid with them
  std::uint64_t dropped_parts = 0;
  bool wrapped = false;
  /// How far replacing crossing facets and removing needles moved the surface: the larger of the Hausdorff distances
  /// there and back, the two acts added. What fills holes, is dropped on request, or lies inside once closed parts are
  /// united does not count. 0 when wrapped.
  double moved = 0;
  double farthest_new_from_old = 0;  ///< one-sided Hausdorff distance, from the new surface to the old
  double farthest_old_from_new = 0;  ///< and back
  double distance_error = 0;         ///< the true distances differ from these by at most this
  double box_diagonal = 0;           ///< of the old surface
};

struct RepairedSurface {
  NeutralSurface surface;  ///< triangles; its notes say what was done in sentences
  RepairReport report;
};

/// Mends a surface (CGAL's polygon mesh processing, in a worker process with limits): merges points and facets that are
/// there twice, drops facets without area, separates sheets at edges of more than two facets, orients, stitches, fills
/// holes, replaces facets that cross, and unites closed parts that cross each other. Seeds of holes and regions are
/// kept, wanted sizes are not. Solids may still touch in edges and points.
/// A repair that moves the surface farther than `max_move` is refused.
/// Promises no success: what is still wrong is found by `find_faults` (inspect_surface.h) and refused by
/// `tetrahedralize`.
RepairedSurface repair_surface(const NeutralSurface& surface, const RepairOptions& options = {});

}  // namespace rhoray::preprocess
