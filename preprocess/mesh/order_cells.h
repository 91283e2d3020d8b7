#pragma once

#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Orders cells so that neighbours are stored close together. Cells are halved by count across the
/// longest axis of their centres, again and again, down to single cells. Cells with the same centre
/// keep the source's order.
///
/// The first half takes the largest power of two below the count. Blocks of 8, 64, 512, ... cells
/// that begin at their multiples are therefore whole parts. Clusters and the tree over them are
/// made of such blocks. Points are ordered by their first use in the new cell order. The order does
/// not depend on the number of threads.
/// @return  for each point, its rank among the mesh's points in the source
Array<std::uint32_t> order_cells(CleanMesh& mesh);

}  // namespace rhoray::preprocess
