#pragma once

#include <array>
#include <bitset>
#include <cstddef>

#include "preprocess/grid/resample/sample.h"

namespace rhoray::preprocess {

/// The samples at the corners of a brick's leaf cells: its own 8 x 8 x 8 and the first ones of the
/// bricks beside it.
class Neighborhood {
 public:
  static constexpr std::size_t edge = SampleLattice::brick_edge;

  /// The number of a leaf cell, or of one of the brick's own samples.
  static constexpr std::size_t place(std::size_t i, std::size_t j, std::size_t k) { return (k * edge + j) * edge + i; }

  void gather(const TouchedBricks& touched, const Index3& brick, const BrickValues& values);

  /// The eight samples of a leaf cell, x fastest.
  std::array<double, 8> corners(std::size_t i, std::size_t j, std::size_t k) const {
    const double* at = values_.data() + (k * wide + j) * wide + i;
    constexpr std::size_t up = wide * wide;
    return {at[0], at[1], at[wide], at[wide + 1], at[up], at[up + 1], at[up + wide], at[up + wide + 1]};
  }

  /// True when all eight samples have data.
  bool is_covered(std::size_t cell) const { return covered_[cell]; }
  std::size_t covered_count() const { return covered_.count(); }
  /// True when all leaf cells are covered.
  bool is_whole() const { return covered_.all(); }

  /// The range of count^3 samples from (i, j, k) on, all with data.
  Interval<double> range_of(std::size_t i, std::size_t j, std::size_t k, std::size_t count) const {
    Interval<double> range;
    for (std::size_t z = k; z < k + count; ++z)
      for (std::size_t y = j; y < j + count; ++y)
        for (std::size_t x = i; x < i + count; ++x) range.include(values_[(z * wide + y) * wide + x]);
    return range;
  }

 private:
  static constexpr std::size_t wide = edge + 1;

  std::array<double, wide * wide * wide> values_{};
  std::bitset<edge * edge * edge> covered_;
};

}  // namespace rhoray::preprocess
