#pragma once

#include <array>

#include "render/exact/polynomial.h"

namespace rhoray::render::exact {

/// One axis of a cell and of a line: the cell is between two planes, the line is at start + t *
/// slope. All finite.
struct AxisOfChord {
  double low, high;
  double start, slope;
};

/// A polynomial with integer coefficients times a positive number.
struct ScaledPolynomial {
  Polynomial polynomial;
  Rational scale;
};

/// Returns rho - offset along the line, as a cubic in t: the trilinear interpolant inside the cell,
/// and its continuation outside.
ScaledPolynomial along(const std::array<double, 8>& corner, double offset, const std::array<AxisOfChord, 3>& axes);

/// The same on the unit cell along p0 + s (p1 - p0), with the difference not rounded.
ScaledPolynomial along_unit_cell(const std::array<double, 8>& corner, double offset, const std::array<double, 3>& p0,
                                 const std::array<double, 3>& p1);

}  // namespace rhoray::render::exact
