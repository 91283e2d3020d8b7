#pragma once

#include <cstdint>

#include "preprocess/neutral.h"

namespace rhoray::study {

/// The unit cube in 6 * edge^3 tetrahedra, with a smooth point field "value" in single precision.
/// Inner points are moved by up to a tenth of a small cube's edge. The result is the same for the
/// same edge.
preprocess::NeutralMesh warped_box(std::int64_t edge);

/// The edge for about this many tetrahedra.
std::int64_t edge_for(std::uint64_t cell_count);

}  // namespace rhoray::study
