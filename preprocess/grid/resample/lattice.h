#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/base/vector.h"
#include "preprocess/resample.h"

namespace rhoray::preprocess {

/// A lattice of samples over the box of a mesh, in the mesh's own frame. Sample (i, j, k) is
/// exactly at (places[0][i], places[1][j], places[2][k]). These are the doubles nearest to low + i
/// * spacing, and the box's far side itself where the last sample falls on it.
struct SampleLattice {
  static constexpr std::int64_t brick_edge = 8;
  static constexpr std::int64_t brick_samples = brick_edge * brick_edge * brick_edge;
  static constexpr std::int64_t largest_axis = std::int64_t{1} << 20;  ///< limit of a packed grid

  Index3 count;  ///< at least 2 on every axis
  Vec3 low;
  Vec3 spacing;
  std::array<std::vector<double>, 3> places;

  Index3 brick_count() const {
    const std::int64_t n = brick_edge;
    return {(count.x + n - 1) / n, (count.y + n - 1) / n, (count.z + n - 1) / n};
  }

  /// Steps of the lattice from its first sample.
  std::array<double, 3> in_steps(const std::array<double, 3>& p) const {
    return {(p[0] - low.x) / spacing.x, (p[1] - low.y) / spacing.y, (p[2] - low.z) / spacing.z};
  }
};

/// The lattice starts at the box's low corner. With `longest_axis` and `sample_count` it ends at
/// the high corner. With `spacing` it ends at the first sample that is not inside the box or that
/// is on its side. Refuses with ErrorCode::usage: fewer than 2 or more than largest_axis samples on
/// an axis, and a spacing that is not a positive number.
SampleLattice choose_samples(const Box3& box, const LatticeRequest& request);

}  // namespace rhoray::preprocess
