#pragma once

#include "render/query/kernels.h"

namespace rhoray::render::wide {

/// The first crossing of an isosurface for groups of rays at once; null where the scalar kernels answer: for volumes
/// other than uniform dense grids with macro levels of factor 4, and for ways other than those of the table in
/// README.md.
Kernel first_crossing_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// Finds the blocks of an isovalue, if they are not kept from before.
/// @return  the boxes around them; none where the scalar kernels answer
std::optional<SurfaceBoxes> prepare_occupancy(const VolumeImplementation& volume, const RayQuery& query,
                                              unsigned threads);

}  // namespace rhoray::render::wide
