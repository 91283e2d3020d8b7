#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/base/vector.h"
#include "render/cell/cubic.h"

namespace rhoray::render {

/// A cell of a grid: values at its eight corners, corner (i, j, k) at index i + 2 j + 4 k, and
/// between them
///
///     rho(u, v, w) = sum over corners of u_i v_j w_k rho_ijk,   u_0 = 1 - u, u_1 = u, ...
///
/// with (u, v, w) in [0, 1]^3 (paper, Appendix A, eq. 1).
template <class Real>
struct TrilinearCellOf {
  using Point = Imath::Vec3<Real>;

  std::array<Real, 8> corner;

  RHORAY_INLINE Real smallest() const { return *std::min_element(corner.begin(), corner.end()); }
  RHORAY_INLINE Real largest() const { return *std::max_element(corner.begin(), corner.end()); }

  /// False when a corner is NaN or infinite: such a cell counts as absent.
  RHORAY_INLINE bool has_data() const {
    return std::all_of(corner.begin(), corner.end(), [](Real f) { return std::isfinite(f); });
  }

  /// Exact at w = 0 and w = 1, so that neighbours agree on a shared face. Where a and b have the
  /// same sign, the result has it too.
  RHORAY_INLINE static Real between(Real a, Real b, Real w) { return (1 - w) * a + w * b; }

  RHORAY_INLINE Real at(const Point& p) const {
    const Real v00 = between(corner[0], corner[1], p.x), v10 = between(corner[2], corner[3], p.x);
    const Real v01 = between(corner[4], corner[5], p.x), v11 = between(corner[6], corner[7], p.x);
    return between(between(v00, v10, p.y), between(v01, v11, p.y), p.z);
  }

  /// Derivatives by u, v, w (paper, Appendix A, with x1 - x0 = 1).
  RHORAY_INLINE Point gradient(const Point& p) const {
    const auto& f = corner;
    return {between(between(f[1] - f[0], f[3] - f[2], p.y), between(f[5] - f[4], f[7] - f[6], p.y), p.z),
            between(between(f[2] - f[0], f[3] - f[1], p.x), between(f[6] - f[4], f[7] - f[5], p.x), p.z),
            between(between(f[4] - f[0], f[5] - f[1], p.x), between(f[6] - f[2], f[7] - f[3], p.x), p.y)};
  }

  /// rho along the straight line from p0 (s = 0) to p1 (s = 1).
  ///
  /// The interpolant is affine in each of u, v, w. So its values G at the corners of the box that
  /// p0 and p1 span give the Bernstein coefficients of the cubic: coefficient n is the mean over
  /// the corners that have n coordinates from p1.
  RHORAY_INLINE CubicOf<Real> along(const Point& p0, const Point& p1) const {
    const auto g = [&](int a, int b, int c) { return at({a ? p1.x : p0.x, b ? p1.y : p0.y, c ? p1.z : p0.z}); };
    return {{g(0, 0, 0), (g(1, 0, 0) + g(0, 1, 0) + g(0, 0, 1)) / 3, (g(1, 1, 0) + g(1, 0, 1) + g(0, 1, 1)) / 3,
             g(1, 1, 1)}};
  }

  /// rho - offset along the same line. The offset is subtracted first, so that large values with
  /// small differences lose no precision.
  RHORAY_INLINE CubicOf<Real> along(const Point& p0, const Point& p1, Real offset) const {
    TrilinearCellOf shifted;
    for (std::size_t c = 0; c < 8; ++c) shifted.corner[c] = corner[c] - offset;
    return shifted.along(p0, p1);
  }
};
using TrilinearCell = TrilinearCellOf<double>;

/// A cell's values minus an offset: corner = (value - offset) / unit.
template <class Real>
struct Differences {
  TrilinearCellOf<Real> cell;
  double unit;  ///< a power of two, 1 in all ordinary cells
};

/// Values minus an offset in numbers of type Real. The offset is subtracted in double: 32-bit
/// integers and doubles far from zero keep their differences. Every corner keeps its side (side.h),
/// however small its difference.
///
/// Magnitudes that would leave the range of Real in a product are scaled to about 1. So what is
/// computed from the differences (positions of roots, sides) does not depend on the unit of the
/// values.
template <class Real>
RHORAY_INLINE Differences<Real> minus(const TrilinearCell& values, double offset) {
  constexpr double large = std::numeric_limits<Real>::max_exponent > 200 ? 0x1p900 : 0x1p60, small = 1 / large;
  std::array<double, 8> f;
  double largest = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    f[c] = values.corner[c] - offset;
    largest = std::max(largest, std::abs(f[c]));
  }
  Differences<Real> result;
  const bool is_far = (largest > large || largest < small) && largest > 0 && std::isfinite(largest);
  result.unit = is_far ? std::ldexp(1.0, std::ilogb(largest)) : 1;
  for (std::size_t c = 0; c < 8; ++c) {
    if (is_far) f[c] /= result.unit;
    Real rounded = static_cast<Real>(f[c]);
    if (f[c] < 0) rounded = std::min(rounded, -std::numeric_limits<Real>::denorm_min());
    result.cell.corner[c] = rounded;
  }
  return result;
}

}  // namespace rhoray::render
