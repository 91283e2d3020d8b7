#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "render/cell/trilinear.h"

/// Certified crossings of a ray in a grid cell: answers that rounding cannot have changed, and
/// "unknown" for the rest.
///
/// The truth is the exact polynomial: corners and isovalue taken as exact doubles, on the straight
/// segment between two points. These points may themselves be known only up to `point_error`, a
/// bound on the distance of each of their coordinates from the exact ray's. Every answer holds for
/// every segment within that bound.
namespace rhoray::render {

enum class Decision { none, crosses, unknown };

struct CertifiedCrossing {
  Decision decision = Decision::unknown;
  double s = 0;        ///< share of the path
  double s_error = 0;  ///< when it crosses: the exact first change of side lies within s_error of s
  int iterations = 0;
  int root_count = 0;  ///< changes of side that were found; not certified
};

struct CertifiedMaximum {
  double value;
  double value_error;  ///< distance bound to the exact maximum; infinite when nothing is certain
  double s;            ///< where `value` is reached
};

/// A cubic in numbers of type Real that is close to the exact one on every segment in question. For
/// all x, y, z in [0, 1] the computed polar(x, y, z) lies within `margin` of the exact polar form.
/// The exact Bernstein coefficients, of the whole or of a part, and all points of the curve are
/// values of this form.
template <class Real>
struct EnclosedCubic {
  CubicOf<Real> cubic;
  Real margin;  ///< infinite when nothing is certain
  double unit;  ///< the exact values are these times unit
};

/// The margin, in units of rounding u = 2^-24 (float) or 2^-53 and of M, the largest |corner -
/// offset|:
///
///   1     the subtraction and its rounding to Real
///   7.5   three interpolations, (1 - w) a + w b each: u/2 |a| from 1 - w, u max(|a|, |b|) from the
///         products, the same from the sum
///   2.7   the mean of three: u (2 + 3)/3 M from two sums, uM from the division
///   7.5   three interpolations of the polar form
///
/// together 18.7 uM; 20 leaves room for the terms in u^2. A coordinate that is off by e moves the
/// value by at most e times the largest difference between corners. There are three coordinates;
/// 3.1 instead of 3 leaves room for points that lie outside the cell by e, which must be at most
/// 1e-3. In float the points themselves are rounded, by up to u/2.
template <class Real>
RHORAY_INLINE EnclosedCubic<Real> enclosed_along(const TrilinearCell& values, const Vec3& in, const Vec3& out,
                                                 double point_error, double offset) {
  constexpr double u = std::numeric_limits<Real>::epsilon() / 2;
  constexpr double coordinate_rounding = std::numeric_limits<Real>::digits < 53 ? u / 2 : 0;
  const auto [cell, unit] = minus<Real>(values, offset);
  const double lo = cell.smallest(), hi = cell.largest();
  const double margin =
      20 * u * std::max(std::abs(lo), std::abs(hi)) + 3.1 * (point_error + coordinate_rounding) * (hi - lo);
  EnclosedCubic<Real> enclosed{cell.along(Imath::Vec3<Real>(in), Imath::Vec3<Real>(out)), static_cast<Real>(margin),
                               unit};
  if (!(point_error <= 1e-3 && std::isfinite(margin))) enclosed.margin = std::numeric_limits<Real>::infinity();
  return enclosed;
}

/// The Bernstein coefficients of the part on [x, y], all within the margin.
template <class Real>
RHORAY_INLINE std::array<Real, 4> part(const CubicOf<Real>& cubic, Real x, Real y) {
  return {cubic.polar(x, x, x), cubic.polar(x, x, y), cubic.polar(x, y, y), cubic.polar(y, y, y)};
}

/// Points that divide [0, 1] so that on each piece the cubic lies between its values at the ends,
/// up to rounding. They are the critical points, or the inflection where there are none. On such a
/// piece the derivative has one sign and is zero or extremal at one end. So its Bernstein
/// coefficients have that sign, and those of the piece are in order.
template <class Real>
struct PieceEnds {
  std::array<Real, 4> s;
  int count;
};
template <class Real>
RHORAY_INLINE PieceEnds<Real> piece_ends(const CubicOf<Real>& cubic) {
  PieceEnds<Real> ends{{0}, 1};
  const auto add = [&](Real s) { ends.s[static_cast<std::size_t>(ends.count++)] = s; };
  const typename CubicOf<Real>::CriticalPoints critical = cubic.critical_points();
  for (int c = 0; c < critical.count; ++c) add(critical.s[static_cast<std::size_t>(c)]);
  if (critical.count == 0) {
    const auto& b = cubic.b;
    const Real bend_0 = b[0] - 2 * b[1] + b[2], bend_1 = b[1] - 2 * b[2] + b[3];
    const Real inflection = bend_0 / (bend_0 - bend_1);
    if (inflection > 0 && inflection < 1) add(inflection);
  }
  add(1);
  return ends;
}

/// A cubic with its sign chosen so that it is positive on the side on which the ray starts. Where
/// it is above the margin the side has not changed; where it is below -margin the side has changed.
template <class Real>
struct StartSideUp {
  CubicOf<Real> cubic;
  Real margin;

  /// Certain that no exact cubic changes side on [x, y]: its convex hull stays on the starting
  /// side.
  RHORAY_INLINE bool is_clear(Real x, Real y) const {
    const std::array<Real, 4> b = part(cubic, x, y);
    return b[0] > margin && b[1] > margin && b[2] > margin && b[3] > margin;
  }

  RHORAY_INLINE bool has_changed(Real s) const { return cubic.polar(s, s, s) < -margin; }

  /// Certain that every exact cubic rises on [0, y]. Its coefficients are off by at most the
  /// margin, so their differences, and what is interpolated between these, are off by at most twice
  /// that. The margin leaves enough room for rounding.
  RHORAY_INLINE bool rises_until(Real y) const {
    const auto& b = cubic.b;
    const Real d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
    const Real e0 = (1 - y) * d0 + y * d1, e1 = (1 - y) * d1 + y * d2;
    const Real least = 2 * margin;
    return d0 > least && e0 > least && (1 - y) * e0 + y * e1 > least;
  }

  /// The same as is_clear(0, y) where the value at 0 is too small to tell its side but the side is
  /// known: a cubic that rises keeps it.
  RHORAY_INLINE bool is_clear_from_start(Real y) const {
    const Real middle = Real(0.5) * y;
    return is_clear(0, y) || (rises_until(middle) && is_clear(middle, y));
  }

  /// The first change of side, given that none comes before x and that the side has changed at y.
  RHORAY_INLINE CertifiedCrossing enclosed_change(Real x, Real y) const {
    RootOf<Real> root{x, 0};
    const Real value_x = cubic.at(x).value, value_y = cubic.at(y).value;
    if (is_inside(value_x) && !is_inside(value_y))
      root = bracketed_root(cubic, x, y, first_guess<Real>({x, value_x, x > 0}, {y, value_y, y < 1}));
    // Move to both sides of the root until the sides are certain; they are certain at x and at y.
    const Real slope = std::abs(cubic.at(root.s).slope);
    // Meaningless where the ray is tangent to the surface.
    const Real likely = Real(1.25) * margin / slope;
    const Real first_step =
        likely < Real(0.5) * (y - x) ? std::max(root_resolution<Real>, likely) : root_resolution<Real>;
    Real hi = y, lo = x;
    for (Real step = first_step; root.s + step < y; step *= 2)
      if (has_changed(root.s + step)) {
        hi = root.s + step;
        break;
      }
    for (Real step = first_step; root.s - step > x; step *= 2)
      if (is_clear(x, root.s - step)) {
        lo = root.s - step;
        break;
      }
    constexpr double rounding = 1 + 0x1p-50;
    return {Decision::crosses, static_cast<double>(root.s),
            rounding * std::max(static_cast<double>(hi) - static_cast<double>(root.s),
                                static_cast<double>(root.s) - static_cast<double>(lo)),
            root.iterations, 1};
  }
};

/// Where the ray first changes side on its path through a cell.
///
/// A decision other than unknown is right for every segment that begins and ends within point_error
/// of `in` and `out` and begins on the side of `starts_inside`. For a segment that certainly begins
/// on the other side, whatever `starts_inside` says, the change is at s = 0. Unknown means that
/// rounding could have changed the decision: the surface is touched or nearly touched, or the exit
/// is so close to it that the exact change may lie behind the exit.
template <class Real>
RHORAY_INLINE CertifiedCrossing certify_crossing(const TrilinearCell& cell, const Vec3& in, const Vec3& out,
                                                 double point_error, double isovalue, bool starts_inside) {
  const EnclosedCubic<Real> enclosed = enclosed_along<Real>(cell, in, out, point_error, isovalue);
  StartSideUp<Real> way{enclosed.cubic, enclosed.margin};
  auto& b = way.cubic.b;
  if (!starts_inside)
    for (Real& coefficient : b) coefficient = -coefficient;

  if (way.margin == 0)  // all corners are the isovalue: inside, everywhere
    return {.decision = starts_inside ? Decision::none : Decision::crosses, .root_count = starts_inside ? 0 : 1};
  const auto is_unchanged = [&](Real coefficient) { return coefficient > way.margin; };
  if (std::all_of(b.begin(), b.end(), is_unchanged)) return {.decision = Decision::none};
  if (b[0] < -way.margin) return {.decision = Decision::crosses, .root_count = 1};

  const PieceEnds<Real> ends = piece_ends(way.cubic);
  for (std::size_t i = 1; i < static_cast<std::size_t>(ends.count); ++i) {
    const Real x = ends.s[i - 1], y = ends.s[i];
    if (i == 1 ? way.is_clear_from_start(y) : way.is_clear(x, y)) continue;
    if (!way.has_changed(y)) return {.decision = Decision::unknown};
    CertifiedCrossing found = way.enclosed_change(x, y);
    for (std::size_t j = i + 1; j < static_cast<std::size_t>(ends.count); ++j)
      found.root_count += is_inside(way.cubic.at(ends.s[j]).value) != is_inside(way.cubic.at(ends.s[j - 1]).value);
    return found;
  }
  return {.decision = Decision::none};
}

/// True when the position of a change is known well enough to be accepted without re-evaluation: to
/// a thousandth of a cell edge in single precision and to a millionth in double. So exact
/// arithmetic is not needed where a ray grazes a surface that it certainly meets. Where the points
/// themselves are known less well than that, the limit is 64 times their error: surfaces down to a
/// few degrees from the chord magnify it by that much.
template <class Real>
RHORAY_INLINE bool is_placed_well(const CertifiedCrossing& found, const Vec3& in, const Vec3& out, double point_error) {
  constexpr double cell_edges = std::numeric_limits<Real>::digits < 53 ? 1e-3 : 1e-6;
  return found.s_error * (out - in).length() <= std::max(cell_edges, 64 * point_error);
}

/// On which side all points within point_error of p lie; nothing when that is not certain.
template <class Real>
RHORAY_INLINE std::optional<bool> certain_side(const TrilinearCell& cell, const Vec3& p, double point_error,
                                               double isovalue) {
  const EnclosedCubic<Real> enclosed = enclosed_along<Real>(cell, p, p, point_error, isovalue);
  if (enclosed.margin == 0) return true;
  const Real value = enclosed.cubic.b[0];
  if (value > enclosed.margin) return true;
  if (value < -enclosed.margin) return false;
  return std::nullopt;
}

/// The largest value on the path through a cell. `value` is reached, up to its error, and no exact
/// value on any of the segments lies above value + value_error. The exact maximum of each segment
/// lies within value_error of `value`.
template <class Real>
RHORAY_INLINE CertifiedMaximum certify_largest_value(const TrilinearCell& cell, const Vec3& in, const Vec3& out,
                                                     double point_error) {
  const double offset = cell.largest();
  const EnclosedCubic<Real> enclosed = enclosed_along<Real>(cell, in, out, point_error, offset);
  const PieceEnds<Real> ends = piece_ends(enclosed.cubic);
  Real best = enclosed.cubic.polar(0, 0, 0), bound = best, s = 0;
  for (std::size_t i = 1; i < static_cast<std::size_t>(ends.count); ++i) {
    const std::array<Real, 4> b = part(enclosed.cubic, ends.s[i - 1], ends.s[i]);
    bound = std::max({bound, b[1], b[2], b[3]});
    if (b[3] > best) best = b[3], s = ends.s[i];
  }
  const double value = offset + enclosed.unit * static_cast<double>(best);
  const double above = enclosed.unit * (static_cast<double>(bound) - static_cast<double>(best) + enclosed.margin);
  const double error = above * (1 + 0x1p-50) + 0x1p-53 * std::abs(value);
  return {value, std::isfinite(error) ? error : std::numeric_limits<double>::infinity(), static_cast<double>(s)};
}

}  // namespace rhoray::render
