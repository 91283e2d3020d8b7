#pragma once

#include <limits>
#include <span>

#include "render/query/kernels.h"

/// Rays that one kernel has followed to a place where it is in doubt, and another follows from there.
namespace rhoray::render {

/// A place of a ray before which, for certain, nothing changes on it.
struct ResumedAt {
  double t = -std::numeric_limits<double>::infinity();  ///< where it passes a plane; before its start: the whole ray
  StartSide side = StartSide::unknown;                  ///< of the ray until it changes
};

/// Of a uniform dense grid's certified first crossings: what single precision has not decided, by double precision or
/// the judge. Where what follows the place leaves a doubt, the whole ray is asked about.
template <class View>
void resume_certified(const View& view, const RayQuery& query, const RayBatch& rays, std::span<const ResumedAt> from,
                      HitBatch& hits, KernelScratch& scratch);

}  // namespace rhoray::render
