#pragma once

#include "render/grid/grid_data.h"

namespace rhoray::render {

/// The samples of a cell and those next to them along each axis.
struct CellSurroundings {
  /// [axis][j + 2 k][i]: row (j, k) of samples along the axis, at -1, 0, 1 and 2 from the cell's
  /// lower corner; j and k count on the other two axes in the order x, y, z. NaN outside the grid.
  double rows[3][4][4];
};

using ReadSurroundings = void (*)(const GridData& grid, const Index3& cell, CellSurroundings& out);

/// The function that reads the samples of a grid, whatever their type and layout.
ReadSurroundings surroundings_reader(const GridData& grid);

/// The gradient at a sample between two others on an axis: that of the parabola through the three.
/// @param before, after  steps to the other two
RHORAY_INLINE double central_difference(double low, double middle, double high, double before, double after) {
  return ((middle - low) / before * after + (high - middle) / after * before) / (before + after);
}

/// The gradient in the grid's frame, interpolated trilinearly between those at the corners of a
/// cell with data. On each axis a corner's gradient is the central difference of the samples beside
/// it. Where one of these has no data (is NaN or infinite) or is outside the grid, it is the
/// one-sided difference, which lies inside the cell. Across a face where all samples have data it
/// is continuous.
/// @param place  in the cell's own coordinates, 0 to 1
template <class Geometry>
RHORAY_INLINE Vec3 smooth_gradient(const Geometry& geometry, const Index3& cell, const Vec3& place,
                                   const CellSurroundings& around) {
  const auto is_data = [](double value) { return value - value == 0; };
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const auto planes = geometry.planes();
    const auto step = [&](std::int64_t from) {
      return planes.position(axis, cell[axis] + from + 1) - planes.position(axis, cell[axis] + from);
    };
    const double width = step(0);
    const double along = place[axis];
    double mean[4];
    for (int row = 0; row < 4; ++row) {
      const double* sample = around.rows[axis][row];
      const double inside = (sample[2] - sample[1]) / width;
      const double at_low =
          is_data(sample[0]) ? central_difference(sample[0], sample[1], sample[2], step(-1), width) : inside;
      const double at_high =
          is_data(sample[3]) ? central_difference(sample[1], sample[2], sample[3], width, step(1)) : inside;
      mean[row] = TrilinearCell::between(at_low, at_high, along);
    }
    const double first = place[axis == 0 ? 1 : 0], second = place[axis == 2 ? 1 : 2];
    gradient[axis] = TrilinearCell::between(TrilinearCell::between(mean[0], mean[1], first),
                                            TrilinearCell::between(mean[2], mean[3], first), second);
  }
  return gradient;
}

}  // namespace rhoray::render
