#pragma once

#include "preprocess/inspect/clean_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Puts neighbours side by side: cells in the order of a Hilbert curve through their centres, those of one place on it
/// in the source's order; points in the order in which the cells then name them first. The curve fills a cube around
/// the mesh in 2^21 steps along each axis. The order does not depend on the number of threads.
/// @return  for each point, how many of the mesh's points come before it in the source
Array<std::uint32_t> order_cells(CleanMesh& mesh);

}  // namespace rhoray::preprocess
