#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace rhoray::render {

/// Where the samples are stored in a grid that stores only some bricks, as plain numbers, for
/// kernels that read samples directly. The bricks that are not stored hold one value each.
///
///     sample (i, j, k)    a = address[0][i] + address[1][j] + address[2][k]
///     its brick's slot    s = slots[a >> shift]
///     s < stored_count    samples[s * stride + (a & (2^shift - 1))]
///     else                values[s - stored_count]; beyond the last value: the last value
template <class T>
struct StoredBricks {
  std::array<const std::uint64_t*, 3> address{};
  std::span<const std::uint32_t> slots;
  int shift = 0;  ///< a brick has 2^shift samples
  const T* samples = nullptr;
  std::uint64_t stride = 0;        ///< from brick to brick, in samples
  std::uint32_t stored_count = 0;  ///< number of stored bricks
  std::span<const T> values;       ///< at least one value
};

}  // namespace rhoray::render
