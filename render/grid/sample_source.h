#pragma once

#include <cstdint>
#include <limits>

#include "formats/base/checks.h"
#include "formats/base/vector.h"
#include "formats/brick_layout.h"
#include "formats/file_description.h"

namespace rhoray::render {

/// Where the samples of a grid are stored, as plain numbers, whatever their type.
///
///     sample (i, j, k)    a = address[0][i] + address[1][j] + address[2][k]
///     a dense grid        samples[a]
///     else, its brick     s = slots[a >> shift]
///     s < stored_count    samples[s * stride + (a & (2^shift - 1))]
///     else                values[s - stored_count]; beyond the last value: the last value
struct SampleSource {
  /// The bricks of a grid that stores only some of them. The others hold one value each.
  struct Bricks {
    const std::uint32_t* slots = nullptr;  ///< null: a dense grid
    int shift = 0;                         ///< a brick has 2^shift samples
    std::uint64_t stride = 0;              ///< from brick to brick, in samples
    std::uint32_t stored_count = 0, last_value = 0;
    const void* values = nullptr;  ///< at least one value
  };

  formats::ElementType type;
  const void* samples;
  const std::uint64_t* address[3];  ///< a sample's address is the sum of its coordinates' entries
  Bricks bricks{};
  int count[3];                 ///< samples per axis
  bool has_whole_rows = false;  ///< samples 4 i to 4 i + 3 of the x axis are contiguous
  /// And 4 j to 4 j + 3 of y follow each other, and so do 4 k to 4 k + 3 of z.
  bool has_whole_bricks = false;
  // The same, with padding that completes the last four; of rows and y, and of z too.
  bool has_padded_squares = false, has_padded_bricks = false;
  bool has_gaps = false;  ///< some samples may be NaN or infinite

  /// A dense grid.
  SampleSource(formats::ElementType element_type, const void* first, const formats::AxisTables& tables,
               const Index3& sample_count);

  /// A grid in bricks.
  SampleSource(formats::ElementType element_type, const void* first, const std::uint64_t* const (&addresses)[3],
               const Bricks& in_bricks, const Index3& sample_count)
      : type(element_type),
        samples(first),
        address{addresses[0], addresses[1], addresses[2]},
        bricks(in_bricks),
        count{static_cast<int>(sample_count.x), static_cast<int>(sample_count.y), static_cast<int>(sample_count.z)} {}
};

/// The samples of one brick, by their address in the grid.
template <class T>
class OneBrick {
 public:
  OneBrick() = default;
  RHORAY_INLINE OneBrick(const SampleSource& source, std::uint64_t number) {
    const SampleSource::Bricks& bricks = source.bricks;
    const std::uint32_t slot = bricks.slots[number];
    if (slot < bricks.stored_count) {
      samples_ = static_cast<const T*>(source.samples) + slot * bricks.stride;
      kept_ = (std::uint64_t{1} << bricks.shift) - 1;
    } else {
      const std::uint32_t value = slot - bricks.stored_count;
      samples_ = static_cast<const T*>(bricks.values) + (value < bricks.last_value ? value : bricks.last_value);
      kept_ = 0;
    }
  }

  RHORAY_INLINE T at_address(std::uint64_t address) const { return samples_[address & kept_]; }

 private:
  const T* samples_ = nullptr;
  /// Address bits that select a sample; 0 where all samples have one value.
  std::uint64_t kept_ = 0;
};

template <class T>
RHORAY_INLINE T sample_in_brick(const SampleSource& source, std::uint64_t address) {
  return OneBrick<T>(source, address >> source.bricks.shift).at_address(address);
}

}  // namespace rhoray::render
