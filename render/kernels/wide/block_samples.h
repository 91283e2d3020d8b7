#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/base/vector.h"
#include "formats/brick_layout.h"

namespace rhoray::render::wide {

/// The samples of a dense grid and where they lie, as plain numbers.
struct SampleSource {
  const void* samples;
  const std::uint64_t* address[3];  ///< of a sample: the sum of its coordinates' entries
  int count[3];                     ///< samples per axis
  bool has_whole_rows;              ///< samples 4 i to 4 i + 3 of an axis x lie side by side
  bool has_whole_bricks;            ///< and 4 j to 4 j + 3 of y behind each other, and so 4 k to 4 k + 3 of z
  bool has_gaps = false;            ///< some samples may be NaN or infinite

  SampleSource(const void* first, const formats::AxisTables& tables, const Index3& sample_count);
};

/// The 5 x 5 x 5 samples around the 4 x 4 x 4 cells of a block, less the isovalue: sample (x, y, z) at x + 5 y + 25 z.
struct alignas(64) BlockSamples {
  static constexpr std::size_t size = 125;

  float difference[128];
  std::uint64_t present;  ///< cells of the block, bit x + 4 y + 16 z, that the lattice has and that have data
  std::uint64_t active;   ///< of these, cells with corners on both sides
  std::uint64_t inside;   ///< cells whose lowest corner is inside
  float range;            ///< certified: that the differences and 0 span, infinite if it is no number; NaN: not known
};

}  // namespace rhoray::render::wide
