#pragma once

#include <stop_token>

#include "render/query/kernels.h"
#include "render/query/machine.h"

namespace rhoray::render::wide {

/// The first crossing with an isosurface for groups of rays at once. Null where the scalar kernels
/// answer instead: for volumes other than uniform grids with macro levels of factor 4, and for
/// methods other than those of the table in render/KERNELS.md.
Kernel first_crossing_kernel(const LoadedDataset& dataset, const Method& method, Machine machine);

/// Finds the blocks of an isovalue unless they are cached.
/// @return  the boxes around them; nothing where the scalar kernels answer
std::optional<SurfaceBoxes> prepare_occupancy(const LoadedDataset& dataset, const RayQuery& query, unsigned threads,
                                              const std::stop_token& stop);

}  // namespace rhoray::render::wide
