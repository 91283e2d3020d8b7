#pragma once

#include "render/query/kernels.h"

namespace rhoray::render {

/// For a mesh's certified first crossings: decides what single precision left undecided, in double
/// precision or by exact arithmetic. For grids see render/grid/reference/resumed.h.
Kernel redoing_kernel();

}  // namespace rhoray::render
