#pragma once

#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Puts neighbours side by side: cells are halved by count across the longest axis of their centres, the halves again,
/// down to single cells; those of one centre in the source's order. The first half takes the largest power of two that
/// is below the count, so that blocks of 8, 64, 512, ... cells that begin at their multiples are whole parts, which is
/// what clusters and the tree over them are made of. Points in the order in which the cells then name them first. The
/// order does not depend on the number of threads.
/// @return  for each point, how many of the mesh's points come before it in the source
Array<std::uint32_t> order_cells(CleanMesh& mesh);

}  // namespace rhoray::preprocess
