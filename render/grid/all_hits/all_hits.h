#pragma once

#include "render/query/all_hits.h"

namespace rhoray::render::wide {

/// All crossings of one or two isosurfaces of a uniform dense grid without gaps, for groups of rays at once; null where
/// there is no such kernel. First crossings are those of first_crossing_kernel, bit for bit.
AllHitsKernel grid_all_hits_kernel(const VolumeImplementation& volume, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::wide
