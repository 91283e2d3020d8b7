#pragma once

#include <cstddef>
#include <cstdint>

#include "render/grid/sample_source.h"

namespace rhoray::render::wide {

/// The 5 x 5 x 5 samples around the 4 x 4 x 4 cells of a block, minus the isovalue: sample (x, y,
/// z) at x + 5 y + 25 z.
struct alignas(64) BlockSamples {
  static constexpr std::size_t size = 125;

  float difference[128];
  /// Cells of the block, bit x + 4 y + 16 z, that the lattice has and that have data.
  std::uint64_t present;
  std::uint64_t active;  ///< of these, cells with corners on both sides
  std::uint64_t inside;  ///< cells whose lowest corner is inside
  /// Certified: span of the differences and 0; infinite if it is not a finite number; NaN: not
  /// known.
  float range;
};

}  // namespace rhoray::render::wide
