#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "render/cell/side.h"

namespace rhoray::render {

/// The last digit of numbers near 1: positions in [0, 1] are not refined further.
template <class Real>
inline constexpr Real root_resolution = std::numeric_limits<Real>::digits < 53 ? Real(1.19e-7) : Real(2.2e-16);

/// A cubic polynomial on [0, 1] by its Bernstein coefficients. It starts at b[0], ends at b[3], and
/// lies between the smallest and the largest of the four.
template <class Real>
struct CubicOf {
  std::array<Real, 4> b;

  struct Jet {
    Real value;
    Real slope;
  };

  /// Value and derivative by de Casteljau's scheme: convex combinations only.
  RHORAY_INLINE Jet at(Real s) const {
    const Real r = 1 - s;
    const Real c0 = r * b[0] + s * b[1], c1 = r * b[1] + s * b[2], c2 = r * b[2] + s * b[3];
    const Real d0 = r * c0 + s * c1, d1 = r * c1 + s * c2;
    return {r * d0 + s * d1, 3 * (d1 - d0)};
  }

  /// The polar form (blossom): affine in each argument, equal to the cubic where all three agree.
  /// The Bernstein coefficients of the part on [x, y] are its values at (x, x, x), (x, x, y), (x,
  /// y, y) and (y, y, y).
  RHORAY_INLINE Real polar(Real x, Real y, Real z) const {
    const Real c0 = (1 - x) * b[0] + x * b[1], c1 = (1 - x) * b[1] + x * b[2], c2 = (1 - x) * b[2] + x * b[3];
    const Real d0 = (1 - y) * c0 + y * c1, d1 = (1 - y) * c1 + y * c2;
    return (1 - z) * d0 + z * d1;
  }

  struct CriticalPoints {
    std::array<Real, 2> s{};  ///< in rising order
    int count = 0;
  };

  /// Where the derivative is zero inside (0, 1). The quadratic is solved without cancellation: one
  /// root as q/a, the other as c/q, where q adds terms of one sign. Candidates that are not finite
  /// fail the comparison with (0, 1).
  RHORAY_INLINE CriticalPoints critical_points() const {
    // Derivative / 3 in Bernstein form, in units of its largest coefficient: squares neither
    // overflow nor vanish.
    Real d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
    const Real unit = std::max({std::abs(d0), std::abs(d1), std::abs(d2)});
    d0 /= unit, d1 /= unit, d2 /= unit;
    const Real a = d0 - 2 * d1 + d2, half_b = d1 - d0;
    const Real discriminant = d1 * d1 - d0 * d2;
    CriticalPoints found;
    // Written so that a NaN, from a constant, also leaves here.
    if (!(discriminant >= 0)) return found;
    const Real q = -(half_b + std::copysign(std::sqrt(discriminant), half_b));
    for (const Real s : {q / a, d0 / q})
      if (s > 0 && s < 1) found.s[static_cast<std::size_t>(found.count++)] = s;
    if (found.count == 2 && found.s[1] < found.s[0]) std::swap(found.s[0], found.s[1]);
    return found;
  }
};
using Cubic = CubicOf<double>;

template <class Real>
struct RootOf {
  Real s;
  int iterations;
};

/// Where a function changes side between `lo` and `hi`, which lie on different sides: Newton's
/// method kept inside the bracket, with bisection where a step would leave it or is longer than
/// half the step before.
///
/// Stops where the bracket or the step is as small as the last digit of numbers near 1. Stops also
/// where the value is no larger than two units of rounding of the largest coefficient, which is
/// less than its own error.
/// @param start  where the search begins, in [lo, hi]
template <class Real>
RHORAY_INLINE RootOf<Real> bracketed_root(const CubicOf<Real>& cubic, Real lo, Real hi, Real start) {
  const bool inside_lo = is_inside(cubic.at(lo).value);
  constexpr Real resolution = root_resolution<Real>, half = 0.5;
  const Real noise = std::numeric_limits<Real>::epsilon() *
                     std::max({std::abs(cubic.b[0]), std::abs(cubic.b[1]), std::abs(cubic.b[2]), std::abs(cubic.b[3])});
  Real s = start, step_before = hi - lo;
  int step = 0;
  for (; step < 100 && hi - lo > resolution; ++step) {
    const typename CubicOf<Real>::Jet f = cubic.at(s);
    if (is_inside(f.value) == inside_lo)
      lo = s;
    else
      hi = s;
    Real next = s - f.value / f.slope;
    // False if not finite.
    const bool is_newton = next >= lo && next <= hi && std::abs(next - s) <= half * step_before;
    if (!is_newton) next = half * (lo + hi);
    if (std::abs(f.value) <= noise) return {s, step + 1};
    step_before = std::abs(next - s);
    if (step_before <= resolution) return {next, step + 1};
    s = next;
  }
  return {s, step};
}

/// An end of a piece on which a cubic is monotone.
template <class Real>
struct PieceEnd {
  Real s, value;
  bool is_critical;
};

/// First guess for the zero of a piece whose ends lie on different sides: the zero of the parabola
/// with its vertex at the critical end. Without a critical end, or with two, the zero of the
/// straight line through both ends.
template <class Real>
RHORAY_INLINE Real first_guess(const PieceEnd<Real>& lo, const PieceEnd<Real>& hi) {
  Real guess = lo.s + (hi.s - lo.s) * (lo.value / (lo.value - hi.value));
  if (lo.is_critical != hi.is_critical) {
    const auto& [vertex, end] = lo.is_critical ? std::pair(lo, hi) : std::pair(hi, lo);
    guess = vertex.s + (end.s - vertex.s) * std::sqrt(vertex.value / (vertex.value - end.value));
  }
  // A guess that is not finite also fails here.
  return guess >= lo.s && guess <= hi.s ? guess : Real(0.5) * (lo.s + hi.s);
}

/// The changes of side of a cubic on [0, 1].
template <class Real>
struct SideChanges {
  int count = 0;  ///< 0: the cubic keeps its side
  Real first = 0;
  int iterations = 0;
};

/// The changes of side in [0, 1], beginning on the side of `starts_inside`. Between 0, the critical
/// points and 1 the cubic is monotone, so each piece changes side at most once. A piece whose ends
/// lie on one side is skipped. A cubic that starts on the other side already changes at 0.
///
/// When `starts_inside` and the side at 1 differ there is always an answer. The exact cubic is zero
/// at the first change and keeps its side before, up to 16 units of rounding (2^-53, or 2^-24 for
/// float) of the largest coefficient. Without an answer it keeps its side throughout.
template <class Real>
RHORAY_INLINE SideChanges<Real> changes_of_side(const CubicOf<Real>& cubic, bool starts_inside) {
  const auto& b = cubic.b;
  const bool b0 = is_inside(b[0]), b1 = is_inside(b[1]), b2 = is_inside(b[2]), b3 = is_inside(b[3]);
  SideChanges<Real> found;
  if (b0 == starts_inside && b1 == starts_inside && b2 == starts_inside && b3 == starts_inside) return found;
  bool side = starts_inside;
  if (b0 != starts_inside) found.count = 1, side = b0;

  PieceEnd<Real> lo{0, b[0], false};
  const auto look_up_to = [&](const PieceEnd<Real>& hi) {
    if (is_inside(hi.value) != side) {
      side = !side;
      if (found.count++ == 0) {
        const RootOf<Real> root = bracketed_root(cubic, lo.s, hi.s, first_guess(lo, hi));
        found.first = root.s, found.iterations = root.iterations;
      }
    }
    lo = hi;
  };
  const typename CubicOf<Real>::CriticalPoints critical = cubic.critical_points();
  for (int c = 0; c < critical.count; ++c) {
    const Real s = critical.s[static_cast<std::size_t>(c)];
    look_up_to({s, cubic.at(s).value, true});
  }
  look_up_to({1, b[3], false});
  return found;
}

/// The first change of side, or nothing.
template <class Real>
RHORAY_INLINE std::optional<Real> first_change_of_side(const CubicOf<Real>& cubic, bool starts_inside) {
  const SideChanges<Real> found = changes_of_side(cubic, starts_inside);
  if (found.count == 0) return std::nullopt;
  return found.first;
}

template <class Real>
struct CubicMaximumOf {
  Real value;
  Real s;
};
using CubicMaximum = CubicMaximumOf<double>;

/// The largest value on [0, 1] and the smallest s where it is reached.
template <class Real>
RHORAY_INLINE CubicMaximumOf<Real> largest_value(const CubicOf<Real>& cubic) {
  CubicMaximumOf<Real> best{cubic.b[0], 0};
  // A maximum inside needs a rise at the start or a fall at the end.
  if (cubic.b[1] > cubic.b[0] || cubic.b[2] > cubic.b[3]) {
    const typename CubicOf<Real>::CriticalPoints critical = cubic.critical_points();
    for (int c = 0; c < critical.count; ++c) {
      const Real s = critical.s[static_cast<std::size_t>(c)];
      if (const Real value = cubic.at(s).value; value > best.value) best = {value, s};
    }
  }
  if (cubic.b[3] > best.value) best = {cubic.b[3], 1};
  return best;
}

}  // namespace rhoray::render
