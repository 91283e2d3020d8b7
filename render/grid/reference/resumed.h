#pragma once

#include <limits>
#include <span>

#include "render/query/kernels.h"

/// For rays that one kernel has followed up to a point where it is in doubt, and that another
/// kernel follows from there.
namespace rhoray::render {

/// A point of a ray before which there is certainly no change of side.
struct ResumedAt {
  /// Where the ray passes a plane; before its start: the whole ray.
  double t = -std::numeric_limits<double>::infinity();
  StartSide side = StartSide::unknown;  ///< side of the ray until it changes
};

/// For a uniform grid's certified first crossings: decides what single precision left undecided, in
/// double precision or by exact arithmetic. Where doubt remains behind the point, the whole ray is
/// traced again.
void resume_certified(const UniformGrid& view, const RayQuery& query, const RayBatch& rays,
                      std::span<const ResumedAt> from, HitBatch& hits, KernelScratch& scratch);

}  // namespace rhoray::render
