#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/exact/enclosure.h"

namespace rhoray::render {

/// A number known to be within `radius` of `middle`, both doubles: interval arithmetic by midpoint
/// and radius, which needs no change of the rounding mode. An overflow makes the radius infinite or
/// NaN, and then nothing is certain.
///
/// Each operation adds to the radius at least twice the maximum of its roundings, so that the
/// roundings of the radius itself are covered as well.
struct Ball {
  double middle = 0;
  double radius = 0;

  /// 1 or -1 when certain, else 0. The comparisons do not round.
  int sign() const { return middle > radius ? 1 : middle < -radius ? -1 : 0; }

  Enclosure enclosure() const {
    if (radius == 0) return {middle, middle};
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {std::nextafter(middle - radius, -infinity), std::nextafter(middle + radius, infinity)};
  }
};

namespace ball_detail {
constexpr double unit = 0x1p-53;                             // the relative error of one rounding
constexpr double tiny = std::numeric_limits<double>::min();  // more than the loss by underflow
}  // namespace ball_detail

inline Ball operator+(const Ball& a, const Ball& b) {
  using namespace ball_detail;
  const double middle = a.middle + b.middle;
  return {middle, (a.radius + b.radius) * (1 + 8 * unit) + 2 * unit * std::abs(middle)};
}

inline Ball operator-(const Ball& a, const Ball& b) {
  return a + Ball{-b.middle, b.radius};
}

inline Ball operator*(const Ball& a, const Ball& b) {
  using namespace ball_detail;
  const double middle = a.middle * b.middle;
  const double spread = std::abs(a.middle) * b.radius + a.radius * (std::abs(b.middle) + b.radius);
  return {middle, spread * (1 + 8 * unit) + 2 * unit * std::abs(middle) + 4 * tiny};
}

/// Nothing is known of the quotient when the divisor may be zero.
inline Ball operator/(const Ball& a, const Ball& b) {
  using namespace ball_detail;
  const double nearest_zero = std::abs(b.middle) - b.radius;
  if (!(nearest_zero > 8 * unit * std::abs(b.middle))) return {0, std::numeric_limits<double>::infinity()};
  const double middle = a.middle / b.middle;
  // |a/b - m| <= (ra + |m| rb) / (|b| - rb)
  const double spread = (a.radius + std::abs(middle) * b.radius) / nearest_zero;
  return {middle, spread * (1 + 32 * unit) + 2 * unit * std::abs(middle) + 4 * tiny};
}

/// (1 - w) a + w b for a weight in [0, 1], as is the middle of its ball: computed as a convex
/// combination it is no wider than necessary.
///
/// Rounding: u (1 - w) |a| from 1 - w, u of each product, u of the sum, together at most 3 u
/// max(|a|, |b|).
inline Ball between(const Ball& a, const Ball& b, const Ball& w) {
  using namespace ball_detail;
  const double radius = std::max(a.radius, b.radius);
  const double size = std::max(std::abs(a.middle), std::abs(b.middle)) + radius;
  return {(1 - w.middle) * a.middle + w.middle * b.middle,
          radius * (1 + 8 * unit) + (2 * w.radius + 4 * unit) * size + 4 * tiny};
}

/// A cubic on [0, 1] in Bernstein coefficients.
struct BallCubic {
  std::array<Ball, 4> b;

  Ball at(double s) const;

  /// Returns its Bernstein coefficients between l and r, both in [0, 1].
  BallCubic on(double l, double r) const;
};

/// rho - offset in a trilinear cell along the straight line from p0 to p1, both in [0, 1]^3.
/// render/cell/trilinear.h explains why these are the Bernstein coefficients.
BallCubic along(const std::array<double, 8>& corner, double offset, const std::array<Ball, 3>& p0,
                const std::array<Ball, 3>& p1);

}  // namespace rhoray::render
