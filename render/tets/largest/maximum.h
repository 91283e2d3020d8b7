#pragma once

#include "render/query/kernels.h"

namespace rhoray::render::wide {

/// The largest value on each ray through a mesh with clusters, for groups of rays at once: value, t and cell are those
/// of the scalar kernel in double precision, bit for bit. Null where the scalar kernels answer: for other volumes, for
/// meshes with leaf lists, or of a size or with values that products of doubles cannot hold, and for ways other than
/// direct (and preview and slack, which mean the same here).
Kernel largest_value_in_tets_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

}  // namespace rhoray::render::wide
