#pragma once

#include <cstdint>
#include <string>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct TetrahedralizeOptions {
  double quality = 1.4;   ///< wanted largest ratio of circumradius to shortest edge (TetGen -q); 0 = no new points
                          ///< for quality
  double max_volume = 0;  ///< of a tetrahedron, in the surface's units cubed (TetGen -a); 0 = no limit.
                          ///< TetGen's smoothing at the end may leave a few cells above it
  bool use_point_sizes = true;  ///< follow NeutralSurface::point_sizes where given (TetGen -m)
  bool regions = true;          ///< number the regions: cell field "region" (TetGen -A)
  std::uint64_t memory_limit_bytes = std::uint64_t{8} << 30;  ///< of the worker
  double time_limit_s = 3600;                                 ///< CPU seconds of the worker
};

/// Fills closed surfaces with tetrahedra (TetGen 1.5, in a worker process with limits on memory and time).
/// A surface that is open, not manifold, or crosses itself is refused with counts and the places of the first faults;
/// so is one on which TetGen fails or dies. The mesh has cell field "region" when there are regions.
NeutralMesh tetrahedralize(const NeutralSurface& surface, const TetrahedralizeOptions& options = {});

}  // namespace rhoray::preprocess
