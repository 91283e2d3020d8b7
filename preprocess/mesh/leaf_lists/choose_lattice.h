#pragma once

#include <cstdint>

#include "formats/leaf_lists.h"

namespace rhoray::preprocess {

struct LeafLatticeRequest {
  double leaf_cell_count = 1;  ///< approximate; refused (ErrorCode::usage) when not in [1, 2^31]
  std::int64_t macro_factor = 4;
  int macro_level_count = 3;
};

/// Chooses nearly cubic leaf cells over the box, at least 1 and at most 2^20 on every axis. The
/// lattice extends beyond the box by 1/1024 of a leaf cell on every side, so that every point of
/// the mesh lies strictly inside.
formats::LeafLattice choose_lattice(const Box3& box, const LeafLatticeRequest& request);

}  // namespace rhoray::preprocess
