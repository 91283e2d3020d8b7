#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "formats/brick_grid.h"

namespace rhoray::formats::details {

/// Reads one field's samples by grid index, for any layout; NaN in a brick that is not stored.
template <class T>
class SamplesByPosition {
 public:
  SamplesByPosition(const BrickGrid& grid, std::size_t field) : grid_(grid), samples_(grid.samples<T>(field)) {
    const BrickLayout& layout = grid.description().layout;
    if (layout.is_sparse) sparse_.emplace(layout, grid.tables(), grid.brick_slots());
  }

  T operator()(std::int64_t i, std::int64_t j, std::int64_t k) const {
    if (!sparse_) return samples_[grid_.tables().address(i, j, k)];
    const std::uint64_t address = (*sparse_)(i, j, k);
    return address == SparseAddress::no_sample ? std::numeric_limits<T>::quiet_NaN() : samples_[address];
  }

  /// True when a stored brick overlaps the range of samples from low to high, both included.
  bool some_stored(const Index3& low, const Index3& high) const {
    if (!sparse_) return true;
    const std::int64_t n = grid_.description().layout.brick_edge;
    for (std::int64_t k = low.z / n; k <= high.z / n; ++k)
      for (std::int64_t j = low.y / n; j <= high.y / n; ++j)
        for (std::int64_t i = low.x / n; i <= high.x / n; ++i)
          if ((*sparse_)(i * n, j * n, k * n) != SparseAddress::no_sample) return true;
    return false;
  }

 private:
  const BrickGrid& grid_;
  std::span<const T> samples_;
  std::optional<SparseAddress> sparse_;
};

}  // namespace rhoray::formats::details
