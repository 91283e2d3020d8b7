#pragma once

#include "render/cell/trilinear.h"
#include "tests/render/exact/sturm.h"

namespace rhoray::tests {

/// Independent implementation of the trilinear interpolant: weights at all eight corners, in exact
/// numbers.
inline Rational field_at(const std::array<double, 8>& corner, const ExactVec3& p) {
  Rational sum = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    const Rational u = c & 1 ? p.x : 1 - p.x, v = c & 2 ? p.y : 1 - p.y, w = c & 4 ? p.z : 1 - p.z;
    sum += u * v * w * exact(corner[c]);
  }
  return sum;
}

inline ExactVec3 on_chord(const Vec3& p0, const Vec3& p1, const Rational& s) {
  const ExactVec3 a = exact(p0), b = exact(p1);
  return {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
}

/// value - isovalue along a chord.
inline Coefficients cubic_along(const render::TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue) {
  return cubic_through(
      [&](const Rational& s) { return Rational(field_at(cell.corner, on_chord(p0, p1, s)) - exact(isovalue)); });
}

}  // namespace rhoray::tests
