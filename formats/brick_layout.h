#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::formats {

/// Where sample (i, j, k) of a grid lies in its array: bricks of n x n x n samples, and superbricks
/// of m.x x m.y x m.z bricks (paper, section 3.1), each in x-fastest order.
///
///     sample -> brick -> superbrick -> array          n = 1, m = (1,1,1): the plain linear order
///     +--+--+   +-----+-----+
///     |n^3  |   | brick brick|  ...
///     +--+--+   +-----+-----+
///
/// The address splits by axis, address(i, j, k) = x[i] + y[j] + z[k] (the paper's lookup tables),
/// for bricks and for the linear order alike: a reader needs no other arithmetic. The far sides are
/// padded to whole superbricks with copies of the last sample; m is chosen so that this costs
/// little.
///
/// A sparse layout keeps only some of the bricks, one after the other in slots; a table
/// (BrickGrid::brick_slots) says where each brick lies. There are no superbricks (m = 1) and n is a
/// power of two; samples of a brick that is not there have no data, and padding is NaN.
struct BrickLayout {
  Index3 sample_count;                   ///< samples per axis that mean something
  std::int64_t brick_edge = 1;           ///< n, samples per axis of a brick
  Index3 superbrick_edge{1, 1, 1};       ///< m, bricks per axis of a superbrick
  bool is_sparse = false;                ///< only stored_brick_count of the bricks are kept
  std::uint64_t stored_brick_count = 0;  ///< of a sparse layout

  /// Plain x-fastest order.
  static BrickLayout linear(const Index3& sample_count);

  /// Bricks of `brick_edge`; m is at most `largest_superbrick` per axis and adds at most 1.5 % of
  /// padding to an axis.
  static BrickLayout bricked(const Index3& sample_count, std::int64_t brick_edge = 4,
                             std::int64_t largest_superbrick = 8);

  /// Stores only some bricks, of 2, 4, 8, 16, 32 or 64 samples per axis.
  static BrickLayout sparse(const Index3& sample_count, std::uint64_t stored_brick_count, std::int64_t brick_edge = 8);

  /// True for the edges that bricks of a sparse layout may have.
  static bool is_sparse_edge(std::int64_t brick_edge);

  bool is_linear() const { return brick_edge == 1 && superbrick_edge == Index3(1, 1, 1); }
  Index3 brick_count() const;  ///< bricks per axis that hold samples, without those that only pad
  Index3 superbrick_count() const;
  /// samples per axis in the array; of a sparse layout if all bricks were stored
  Index3 padded_count() const;

  /// [superbricks, m.z, m.y, m.x, n, n, n]; [z, y, x] when linear; [slots, n, n, n] when sparse.
  std::vector<std::uint64_t> shape() const;

  friend bool operator==(const BrickLayout&, const BrickLayout&) = default;
};

/// The three lookup tables of a layout, one entry per padded sample of the axis. For a sparse
/// layout the address is the one that the sample would have if all bricks were stored, x fastest:
/// brick number * n^3 + position in the brick.
struct AxisTables {
  explicit AxisTables(const BrickLayout& layout);

  std::uint64_t address(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return x[static_cast<std::size_t>(i)] + y[static_cast<std::size_t>(j)] + z[static_cast<std::size_t>(k)];
  }

  std::vector<std::uint64_t> x, y, z;
};

}  // namespace rhoray::formats
