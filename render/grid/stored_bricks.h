#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace rhoray::render {

/// Where the samples of a grid lie of which only some bricks are stored, as plain numbers: for kernels that read
/// samples by themselves. The bricks that are not stored hold one value each.
///
///     sample (i, j, k)    a = address[0][i] + address[1][j] + address[2][k]
///     its brick's slot    s = slots[a >> shift]
///     s < stored_count    samples[s * stride + (a & (2^shift - 1))]
///     else                values[s - stored_count], of slots beyond the last one
template <class T>
struct StoredBricks {
  std::array<const std::uint64_t*, 3> address{};
  std::span<const std::uint32_t> slots;
  int shift = 0;  ///< a brick has 2^shift samples
  const T* samples = nullptr;
  std::uint64_t stride = 0;        ///< from brick to brick, in samples
  std::uint32_t stored_count = 0;  ///< bricks
  std::span<const T> values;       ///< at least one
};

}  // namespace rhoray::render
