#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/grid/resample/lattice.h"

namespace rhoray::preprocess {

/// Up to 8 x 8 x 8 points to be located together: rows along x. Point i of row (j, k) is at (x[i] +
/// shift[row], y[row], z[row]) with row = k * 8 + j, in the mesh's frame.
struct PointRows {
  static constexpr std::size_t edge = SampleLattice::brick_edge;

  Index3 first;          ///< the lattice's sample at or below the first point
  Index3 size;           ///< points per axis
  Vec3 inverse_spacing;  ///< of the lattice
  /// only rows whose j and k are multiples of it have points: 1, 2 or 4
  std::int64_t row_step = 1;
  /// largest distance of a point above its sample on any axis, in steps: 0 or 1
  double spread = 0;
  std::array<double, edge> x;
  std::array<double, edge * edge> shift, y, z;
  /// Approximately the same in steps from the first sample, consecutive for the rows that have
  /// points.
  std::array<float, edge * edge> shift_steps, y_steps, z_steps;
};

/// The samples of a brick.
PointRows rows_of_samples(const SampleLattice& lattice, const Index3& brick);

/// One point in each leaf cell of a brick, or in those of every second or fourth row in y and z. It
/// has the same local coordinates in all cells of a row, and different ones in each row. Together,
/// the rows of 1, 4 or 16 neighbouring bricks have the 64 points of a rank-1 lattice of the unit
/// cube, each once. The points are therefore spread evenly over the local coordinates.
PointRows rows_of_probes(const SampleLattice& lattice, const Index3& brick, std::int64_t row_step);

/// The tetrahedra that hold the points, and the barycentric weights. Index (k * 8 + j) * 8 + i.
struct Places {
  static constexpr std::uint32_t outside = 0xffffffff;

  std::array<std::uint32_t, SampleLattice::brick_samples> cell;
  /// none negative, their sum 1
  std::array<std::array<double, 4>, SampleLattice::brick_samples> weights;
  std::array<bool, SampleLattice::brick_samples> is_strict;  ///< inside, not on a face
};

/// A further tetrahedron, after the first one, that holds a point.
struct SecondClaim {
  std::uint32_t point;  ///< index in Places
  std::uint32_t cell;
  std::array<double, 4> weights;
  bool overlaps;  ///< the point lies inside one of the two, not only on faces of both
};

/// Decides for every point in which tetrahedron it lies. Tetrahedra are closed: a point on a shared
/// face, edge or vertex belongs to the lowest cell that has it. A tetrahedron of zero volume holds
/// no point. The decision is exact for the points' doubles (inspect/orientation.h): there are no
/// false negatives inside a conforming mesh and no false positives outside.
///
///      f_a = 6 * volume with vertex a moved to the point
///      inside when no f_a is negative; weights f_a / sum
///
/// Along a row every f_a is linear. A row therefore needs four divisions for the interval in which
/// a filter with a bound on rounding is sure. The few points at its ends that the filter leaves
/// open are decided in exact arithmetic.
///
/// @param cells    of the mesh, none of negative orientation
/// @param touched  ascending indices of the cells that touch the points' box; others are not
///                 examined
/// @param second   when not null, every further claim to a point is added
void locate(std::span<const std::array<double, 3>> points, std::span<const std::array<std::uint32_t, 4>> cells,
            std::span<const std::uint32_t> touched, const SampleLattice& lattice, const PointRows& rows, Places& places,
            std::vector<SecondClaim>* second);

}  // namespace rhoray::preprocess
