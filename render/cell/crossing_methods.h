#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/cell/trilinear.h"

namespace rhoray::render {

/// How a ray's path through one grid cell is searched for the first change of side.
///
///   preview    sides at entry and exit only, and one secant step: a cell that the ray enters and
///              leaves on one side is skipped, whatever lies between
///   paper      Appendix A: the cubic expanded about the ray's origin, wherever that is, and solved
///              in closed form
///   bracketed  the cubic in Bernstein form on the chord, split at its extrema; in each piece
///              Newton's method in a bracket
enum class CrossingMethod { preview, paper, bracketed };

/// A ray's path through a cell, in the cell's own coordinates.
struct CellPassage {
  /// Points of entry and exit in [0, 1]^3, exactly 0 or 1 on the planes passed.
  Vec3 in, out;
  Vec3 origin, direction;  ///< the ray itself
  double t_in, t_out;
  /// The ray starts at `in`, in a crossing: its side there is given and is not the field's sign.
  bool starts_in_crossing = false;
};

struct CellCrossing {
  bool crosses = false;
  double s = 0;  ///< share of the path from `in` to `out`
  int iterations = 0;
  int root_count = 0;  ///< crossings on the path that the method knows of
};

/// A cubic by the powers of t: a t^3 + b t^2 + c t + d.
template <class Real>
struct PowerCubic {
  Real a, b, c, d;
};

template <class Real>
struct RealRoots {
  std::array<Real, 3> t{};
  int count = 0;
  RHORAY_INLINE void add(Real root) { t[static_cast<std::size_t>(count++)] = root; }
};

/// The magnitude that counts as zero in Schwarze's solver. The paper sets it to this value "which
/// provided for maximum stability for large coefficients" (Parker et al. 1999, Appendix A);
/// Graphics Gems prints 1e-9.
inline constexpr double eqn_eps = 1e-30;

/// The real roots of a t^3 + b t^2 + c t + d in closed form, after J. Schwarze, "Cubic and Quartic
/// Roots", Graphics Gems (1990). The cubic is reduced to x^3 + 3 p x + 2 q; then Cardano's formula
/// gives one real root, or the trigonometric formula three. Linear and quadratic cases are treated
/// separately, as the paper adds them. Numbers of magnitude at most eqn_eps count as zero. This
/// bound is absolute, so the answer depends on the unit of the values. The roots are in no
/// particular order.
template <class Real>
RHORAY_INLINE RealRoots<Real> closed_form_roots(const PowerCubic<Real>& f) {
  const auto is_zero = [](Real x) { return std::abs(x) <= static_cast<Real>(eqn_eps); };
  RealRoots<Real> roots;
  if (is_zero(f.a) && is_zero(f.b)) {
    if (!is_zero(f.c)) roots.add(-f.d / f.c);
    return roots;
  }
  if (is_zero(f.a)) {  // t^2 + 2 p t + q
    const Real p = f.c / (2 * f.b), q = f.d / f.b, discriminant = p * p - q;
    if (is_zero(discriminant)) {
      roots.add(-p);
    } else if (discriminant > 0) {
      const Real root = std::sqrt(discriminant);
      roots.add(-p + root), roots.add(-p - root);
    }
    return roots;
  }
  // t = x - shift makes the square term vanish.
  const Real b = f.b / f.a, c = f.c / f.a, d = f.d / f.a, shift = b / 3;
  const Real p = (c - b * shift) / 3, q = (2 * shift * shift * shift - shift * c + d) / 2;
  const Real discriminant = q * q + p * p * p;
  if (is_zero(discriminant)) {
    const Real u = std::cbrt(-q);
    roots.add(2 * u - shift);
    if (!is_zero(q)) roots.add(-u - shift);
  } else if (discriminant < 0) {
    const Real radius = std::sqrt(-p), third = std::numbers::pi_v<Real> / 3;
    const Real angle = std::acos(-q / (radius * radius * radius)) / 3;
    roots.add(2 * radius * std::cos(angle) - shift);
    roots.add(-2 * radius * std::cos(angle + third) - shift);
    roots.add(-2 * radius * std::cos(angle - third) - shift);
  } else {
    const Real root = std::sqrt(discriminant);
    roots.add(std::cbrt(root - q) - std::cbrt(root + q) - shift);
  }
  return roots;
}

/// rho - isovalue along a ray a + t b by powers of t, summed over the corners as in Appendix A of
/// the paper and in its order of operations: the isovalue is subtracted last. u_0 = 1 - u falls
/// along the ray where u_1 = u rises; the paper prints the signs of their slopes exchanged.
template <class Real>
RHORAY_INLINE PowerCubic<Real> expanded_at_origin(const TrilinearCell& cell, const Vec3& origin, const Vec3& direction,
                                                  double isovalue) {
  struct Linear {
    Real a, b;
  };
  const auto coordinate = [&](int axis, bool upper) -> Linear {
    const Real a = static_cast<Real>(origin[axis]), b = static_cast<Real>(direction[axis]);
    return upper ? Linear{a, b} : Linear{1 - a, -b};
  };
  PowerCubic<Real> sum{0, 0, 0, 0};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const Linear u = coordinate(0, corner & 1), v = coordinate(1, corner & 2), w = coordinate(2, corner & 4);
    const Real rho = static_cast<Real>(cell.corner[corner]);
    sum.a += u.b * v.b * w.b * rho;
    sum.b += (u.a * v.b * w.b + u.b * v.a * w.b + u.b * v.b * w.a) * rho;
    sum.c += (u.b * v.a * w.a + u.a * v.b * w.a + u.a * v.a * w.b) * rho;
    sum.d += u.a * v.a * w.a * rho;
  }
  sum.d -= static_cast<Real>(isovalue);
  return sum;
}

namespace crossing_methods {

/// The smallest root between t_in and t_out. The method ignores sides: every root is a crossing.
template <class Real>
RHORAY_INLINE CellCrossing paper(const TrilinearCell& cell, const CellPassage& way, double isovalue) {
  const RealRoots<Real> roots = closed_form_roots(expanded_at_origin<Real>(cell, way.origin, way.direction, isovalue));
  const Real t_in = static_cast<Real>(way.t_in), t_out = static_cast<Real>(way.t_out);
  CellCrossing found;
  Real first = t_out;
  for (int r = 0; r < roots.count; ++r) {
    const Real t = roots.t[static_cast<std::size_t>(r)];
    if (!(t >= t_in && t <= t_out)) continue;  // a NaN root leaves here
    ++found.root_count;
    first = std::min(first, t);
  }
  found.crosses = found.root_count > 0;
  if (found.crosses && t_out > t_in) found.s = static_cast<double>((first - t_in) / (t_out - t_in));
  return found;
}

/// The value at a crossing for a ray that continues on the given side. Where rounding has put the
/// value on the other side, returns the nearest value of the given side.
template <class Real>
RHORAY_INLINE Real on_side(Real value, bool inside) {
  if (is_inside(value) == inside) return value;
  return inside ? Real(0) : -std::numeric_limits<Real>::min();
}

template <class Real>
RHORAY_INLINE CellCrossing preview(const TrilinearCellOf<Real>& differences, const CellPassage& way,
                                   bool starts_inside) {
  Real at_in = differences.at(Imath::Vec3<Real>(way.in));
  if (way.starts_in_crossing) at_in = on_side(at_in, starts_inside);
  const Real at_out = differences.at(Imath::Vec3<Real>(way.out));
  CellCrossing found{.iterations = 1, .root_count = 1};
  if (is_inside(at_in) != starts_inside) {
    found.crosses = true;
  } else if (is_inside(at_out) != starts_inside) {
    found.crosses = true;
    found.s = static_cast<double>(at_in / (at_in - at_out));
  } else {
    found = {};
  }
  return found;
}

template <class Real>
RHORAY_INLINE CellCrossing bracketed(CubicOf<Real> cubic, const CellPassage& way, bool starts_inside) {
  if (way.starts_in_crossing) cubic.b[0] = on_side(cubic.b[0], starts_inside);
  const SideChanges<Real> changes = changes_of_side(cubic, starts_inside);
  return {changes.count > 0, static_cast<double>(changes.first), changes.iterations, changes.count};
}

}  // namespace crossing_methods

/// The first change of side on a ray's path through a cell, by the given method, in numbers of type
/// Real.
/// @param starts_inside  the side on which the ray comes to `in`; `paper` ignores it
template <class Real>
RHORAY_INLINE CellCrossing find_crossing(CrossingMethod method, const TrilinearCell& cell, const CellPassage& way,
                                         double isovalue, bool starts_inside) {
  if (method == CrossingMethod::paper) return crossing_methods::paper<Real>(cell, way, isovalue);
  const TrilinearCellOf<Real> differences = minus<Real>(cell, isovalue).cell;
  if (method == CrossingMethod::preview) return crossing_methods::preview<Real>(differences, way, starts_inside);
  const Imath::Vec3<Real> in(way.in), out(way.out);
  return crossing_methods::bracketed(differences.along(in, out), way, starts_inside);
}

}  // namespace rhoray::render
