#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::formats {

/// Index of sample (i, j, k) in a grid's array. Samples form bricks of n x n x n, bricks form
/// superbricks of m.x x m.y x m.z bricks (paper, section 3.1); each is in x-fastest order.
///
///     sample -> brick -> superbrick -> array          n = 1, m = (1,1,1): the plain linear order
///     +--+--+   +-----+-----+
///     |n^3  |   | brick brick|  ...
///     +--+--+   +-----+-----+
///
/// The address is a sum over the axes, address(i, j, k) = x[i] + y[j] + z[k] (the paper's lookup
/// tables). This holds for bricks and for the linear order, so a reader needs no other arithmetic.
/// The upper ends of the axes are padded to whole superbricks with copies of the last sample; m is
/// chosen to keep this padding small.
///
/// A sparse layout keeps only some of the bricks, stored one after the other in slots. A table
/// (BrickGrid::brick_slots) gives the slot of each brick. There are no superbricks (m = 1), and n
/// is a power of two. Samples of a brick that is not stored have no data; padding is NaN.
struct BrickLayout {
  Index3 sample_count;                   ///< samples per axis, without padding
  std::int64_t brick_edge = 1;           ///< n, samples per axis of a brick
  Index3 superbrick_edge{1, 1, 1};       ///< m, bricks per axis of a superbrick
  bool is_sparse = false;                ///< only stored_brick_count of the bricks are kept
  std::uint64_t stored_brick_count = 0;  ///< only of a sparse layout

  /// Plain x-fastest order.
  static BrickLayout linear(const Index3& sample_count);

  /// Bricks with edge `brick_edge`. m is at most `largest_superbrick` per axis and adds at most 1.5
  /// % of padding to an axis.
  static BrickLayout bricked(const Index3& sample_count, std::int64_t brick_edge = 4,
                             std::int64_t largest_superbrick = 8);

  /// Stores only some bricks; their edge is 2, 4, 8, 16, 32 or 64 samples.
  static BrickLayout sparse(const Index3& sample_count, std::uint64_t stored_brick_count, std::int64_t brick_edge = 8);

  /// True for edges that bricks of a sparse layout may have.
  static bool is_sparse_edge(std::int64_t brick_edge);

  bool is_linear() const { return brick_edge == 1 && superbrick_edge == Index3(1, 1, 1); }
  Index3 brick_count() const;  ///< bricks per axis that hold samples, without padding
  Index3 superbrick_count() const;
  /// Samples per axis in the array; for a sparse layout, as if all bricks were stored.
  Index3 padded_count() const;

  /// [superbricks, m.z, m.y, m.x, n, n, n]; [z, y, x] when linear; [slots, n, n, n] when sparse.
  std::vector<std::uint64_t> shape() const;

  friend bool operator==(const BrickLayout&, const BrickLayout&) = default;
};

/// The three lookup tables of a layout, one entry per padded sample of the axis. For a sparse
/// layout they give the address as if all bricks were stored, x fastest: brick number * n^3 + index
/// in the brick.
struct AxisTables {
  explicit AxisTables(const BrickLayout& layout);

  std::uint64_t address(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return x[static_cast<std::size_t>(i)] + y[static_cast<std::size_t>(j)] + z[static_cast<std::size_t>(k)];
  }

  std::vector<std::uint64_t> x, y, z;
};

}  // namespace rhoray::formats
