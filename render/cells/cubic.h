#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/cells/side.h"

namespace rhoray::render {

/// A cubic polynomial on [0, 1] by its Bernstein coefficients: it starts at b[0], ends at b[3], and lies between the
/// smallest and the largest of the four.
struct Cubic {
  std::array<double, 4> b;

  struct Jet {
    double value;
    double slope;
  };

  /// Value and derivative by de Casteljau's scheme: convex combinations only.
  RHORAY_INLINE Jet at(double s) const {
    const double r = 1 - s;
    const double c0 = r * b[0] + s * b[1], c1 = r * b[1] + s * b[2], c2 = r * b[2] + s * b[3];
    const double d0 = r * c0 + s * c1, d1 = r * c1 + s * c2;
    return {r * d0 + s * d1, 3 * (d1 - d0)};
  }

  struct CriticalPoints {
    std::array<double, 2> s;  ///< rising
    int count = 0;
  };

  /// Where the derivative is zero inside (0, 1). The quadratic is solved without cancellation: one root as q/a, the
  /// other as c/q, where q adds terms of one sign. Not finite candidates fail the comparison with (0, 1).
  RHORAY_INLINE CriticalPoints critical_points() const {
    // Derivative / 3 in Bernstein form, in units of its largest coefficient: squares neither overflow nor vanish.
    double d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
    const double unit = std::max({std::abs(d0), std::abs(d1), std::abs(d2)});
    d0 /= unit, d1 /= unit, d2 /= unit;
    const double a = d0 - 2 * d1 + d2, half_b = d1 - d0;
    const double discriminant = d1 * d1 - d0 * d2;
    CriticalPoints found;
    if (!(discriminant >= 0)) return found;  // written so that a NaN, from a constant, also leaves here
    const double q = -(half_b + std::copysign(std::sqrt(discriminant), half_b));
    for (const double s : {q / a, d0 / q})
      if (s > 0 && s < 1) found.s[static_cast<std::size_t>(found.count++)] = s;
    if (found.count == 2 && found.s[1] < found.s[0]) std::swap(found.s[0], found.s[1]);
    return found;
  }
};

/// Where a function changes side between `lo` and `hi`, which lie on different sides: Newton's method kept inside the
/// bracket, bisection where a step would leave it or the bracket does not shrink by half in two steps.
/// Stops where the bracket or the step is as small as the last digit of numbers near 1.
RHORAY_INLINE double bracketed_root(const Cubic& cubic, double lo, double hi) {
  const bool inside_lo = is_inside(cubic.at(lo).value);
  constexpr double resolution = 2.2e-16;  // s lies in [0, 1]
  double s = 0.5 * (lo + hi);
  double width_before = hi - lo;
  for (int step = 0; step < 100 && hi - lo > resolution; ++step) {
    const Cubic::Jet f = cubic.at(s);
    if (is_inside(f.value) == inside_lo)
      lo = s;
    else
      hi = s;
    const double newton = s - f.value / f.slope;
    const bool shrinks = step % 2 == 0 || hi - lo < 0.5 * width_before;
    if (step % 2 == 1) width_before = hi - lo;
    double next = 0.5 * (lo + hi);
    if (shrinks && newton >= lo && newton <= hi) next = newton;  // false for a newton that is not finite
    if (std::abs(next - s) <= resolution) return next;
    s = next;
  }
  return s;
}

/// The first point in [0, 1] where the cubic is on another side of zero than `starts_inside`; nothing when there is
/// none. Between 0, the critical points and 1 the cubic is monotone, so each piece changes side at most once; a piece
/// whose ends lie on one side is passed by. A cubic that starts on the other side already gives 0.
///
/// When the sides at 0 and 1 differ there is always an answer. Up to 16 units of rounding (2^-53) of the largest
/// coefficient the exact cubic is zero there and keeps its side before; without an answer it keeps its side throughout.
RHORAY_INLINE std::optional<double> first_change_of_side(const Cubic& cubic, bool starts_inside) {
  const auto& b = cubic.b;
  if (is_inside(b[0]) != starts_inside) return 0.0;
  const bool b1 = is_inside(b[1]), b2 = is_inside(b[2]), b3 = is_inside(b[3]);
  if (b1 == starts_inside && b2 == starts_inside && b3 == starts_inside) return std::nullopt;

  double lo = 0;
  const Cubic::CriticalPoints critical = cubic.critical_points();
  for (int c = 0; c < critical.count; ++c) {
    const double s = critical.s[static_cast<std::size_t>(c)];
    if (is_inside(cubic.at(s).value) != starts_inside) return bracketed_root(cubic, lo, s);
    lo = s;
  }
  if (b3 != starts_inside) return bracketed_root(cubic, lo, 1);
  return std::nullopt;
}

struct CubicMaximum {
  double value;
  double s;
};

/// The largest value on [0, 1] and the smallest s where it is reached.
RHORAY_INLINE CubicMaximum largest_value(const Cubic& cubic) {
  CubicMaximum best{cubic.b[0], 0};
  // A maximum inside needs a rise at the start or a fall at the end.
  if (cubic.b[1] > cubic.b[0] || cubic.b[2] > cubic.b[3]) {
    const Cubic::CriticalPoints critical = cubic.critical_points();
    for (int c = 0; c < critical.count; ++c) {
      const double s = critical.s[static_cast<std::size_t>(c)];
      if (const double value = cubic.at(s).value; value > best.value) best = {value, s};
    }
  }
  if (cubic.b[3] > best.value) best = {cubic.b[3], 1};
  return best;
}

}  // namespace rhoray::render
