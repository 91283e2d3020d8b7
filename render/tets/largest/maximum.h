#pragma once

#include "render/query/kernels.h"
#include "render/query/machine.h"

namespace rhoray::render::wide {

/// Returns the kernel that finds the largest value on each ray through a mesh with clusters, for
/// groups of rays at once. Value, t and cell are those of the scalar kernel in double precision,
/// bit for bit. Null where the scalar kernels are used: for other volumes; for meshes with leaf
/// lists, or whose size or values exceed what products of doubles can hold; and for methods other
/// than direct (and preview and slack, which are equivalent here).
Kernel largest_value_in_tets_kernel(const LoadedDataset& dataset, const Method& method, Machine machine);

}  // namespace rhoray::render::wide
