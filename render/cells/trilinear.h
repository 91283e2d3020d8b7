#pragma once

#include <algorithm>
#include <array>

#include "formats/base/vector.h"
#include "render/cells/cubic.h"

namespace rhoray::render {

/// A cell of a grid: values at its eight corners, corner (i, j, k) at position i + 2 j + 4 k, and between them
///
///     rho(u, v, w) = sum over corners of u_i v_j w_k rho_ijk,   u_0 = 1 - u, u_1 = u, ...   (paper, Appendix A, eq. 1)
///
/// with (u, v, w) in [0, 1]^3.
struct TrilinearCell {
  std::array<double, 8> corner;

  RHORAY_INLINE double smallest() const { return *std::min_element(corner.begin(), corner.end()); }
  RHORAY_INLINE double largest() const { return *std::max_element(corner.begin(), corner.end()); }

  /// False when a corner is NaN or infinite: the cell is absent.
  RHORAY_INLINE bool has_data() const {
    return std::all_of(corner.begin(), corner.end(), [](double f) { return std::isfinite(f); });
  }

  /// Exact at w = 0 and w = 1, so that neighbours agree on a shared face; and of the sign of a and b where they agree.
  RHORAY_INLINE static double between(double a, double b, double w) { return (1 - w) * a + w * b; }

  RHORAY_INLINE double at(const Vec3& p) const {
    const double v00 = between(corner[0], corner[1], p.x), v10 = between(corner[2], corner[3], p.x);
    const double v01 = between(corner[4], corner[5], p.x), v11 = between(corner[6], corner[7], p.x);
    return between(between(v00, v10, p.y), between(v01, v11, p.y), p.z);
  }

  /// Derivatives by u, v, w (paper, Appendix A, with x1 - x0 = 1).
  RHORAY_INLINE Vec3 gradient(const Vec3& p) const {
    const auto& f = corner;
    return {between(between(f[1] - f[0], f[3] - f[2], p.y), between(f[5] - f[4], f[7] - f[6], p.y), p.z),
            between(between(f[2] - f[0], f[3] - f[1], p.x), between(f[6] - f[4], f[7] - f[5], p.x), p.z),
            between(between(f[4] - f[0], f[5] - f[1], p.x), between(f[6] - f[2], f[7] - f[3], p.x), p.y)};
  }

  /// rho - offset along the straight line from p0 (s = 0) to p1 (s = 1).
  ///
  /// The interpolant is affine in each of u, v, w; its values G at the corners of the box that p0 and p1 span are
  /// therefore, averaged over the corners with equally many coordinates from p1, the Bernstein coefficients of the
  /// cubic. The offset is subtracted first, so that large values with small differences lose nothing.
  RHORAY_INLINE Cubic along(const Vec3& p0, const Vec3& p1, double offset) const {
    TrilinearCell shifted;
    for (std::size_t c = 0; c < 8; ++c) shifted.corner[c] = corner[c] - offset;
    const auto g = [&](int a, int b, int c) { return shifted.at({a ? p1.x : p0.x, b ? p1.y : p0.y, c ? p1.z : p0.z}); };
    return {{g(0, 0, 0), (g(1, 0, 0) + g(0, 1, 0) + g(0, 0, 1)) / 3, (g(1, 1, 0) + g(1, 0, 1) + g(0, 1, 1)) / 3,
             g(1, 1, 1)}};
  }
};

}  // namespace rhoray::render
