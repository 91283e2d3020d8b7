#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/base/vector.h"
#include "formats/brick_layout.h"
#include "render/grid/stored_bricks.h"

namespace rhoray::render::wide {

/// Where the samples of a grid are stored, as plain numbers.
struct SampleSource {
  /// The part of StoredBricks that a dense grid does not have.
  struct Bricks {
    const std::uint32_t* slots = nullptr;  ///< null: a dense grid
    int shift = 0;
    std::uint64_t stride = 0;
    std::uint32_t stored_count = 0, last_value = 0;
    const void* values = nullptr;
  };

  const void* samples;
  const std::uint64_t* address[3];  ///< a sample's address is the sum of its coordinates' entries
  Bricks bricks{};
  int count[3];         ///< samples per axis
  bool has_whole_rows;  ///< samples 4 i to 4 i + 3 of the x axis are contiguous
  /// And 4 j to 4 j + 3 of y follow each other, and so do 4 k to 4 k + 3 of z.
  bool has_whole_bricks;
  bool has_gaps = false;  ///< some samples may be NaN or infinite

  SampleSource(const void* first, const formats::AxisTables& tables, const Index3& sample_count);

  template <class T>
  SampleSource(const StoredBricks<T>& stored, const Index3& sample_count)
      : samples(stored.samples),
        address{stored.address[0], stored.address[1], stored.address[2]},
        bricks{.slots = stored.slots.data(),
               .shift = stored.shift,
               .stride = stored.stride,
               .stored_count = stored.stored_count,
               .last_value = static_cast<std::uint32_t>(stored.values.size() - 1),
               .values = stored.values.data()},
        count{static_cast<int>(sample_count.x), static_cast<int>(sample_count.y), static_cast<int>(sample_count.z)},
        has_whole_rows(false),
        has_whole_bricks(false) {}
};

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
