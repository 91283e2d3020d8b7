#pragma once

#include "render/query/kernels.h"
#include "render/query/machine.h"

namespace rhoray::render::wide {

/// The largest value on each ray, for groups of rays at once. Value, t and cell equal those of the
/// scalar kernel in double precision, bit for bit. Null where the scalar kernels answer instead:
/// for volumes other than uniform grids with macro levels of factor 4, and for methods other than
/// direct (and preview and slack, which mean the same here).
Kernel largest_value_kernel(const LoadedDataset& dataset, const Method& method, Machine machine);

}  // namespace rhoray::render::wide
