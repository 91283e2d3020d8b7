#pragma once

#include "render/query/all_hits.h"
#include "render/query/machine.h"

namespace rhoray::render::wide {

/// All crossings with one or two isosurfaces of a uniform grid without gaps, for groups of rays at
/// once. Null where there is no such kernel. First crossings equal those of first_crossing_kernel,
/// bit for bit.
AllHitsKernel grid_all_hits_kernel(const LoadedDataset& dataset, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::wide
