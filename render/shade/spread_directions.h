#pragma once

#include <cmath>
#include <cstdint>

#include "formats/base/vector.h"

namespace rhoray::render {

/// Directions of a pixel's occlusion and soft-shadow rays. They are computed from the points of
/// Roberts' R2 sequence (multiples of the inverse plastic number and its square). SplitMix64
/// computes the shift of the points from the pixel's position. The directions depend on nothing
/// else, and use only operations that IEEE 754 rounds exactly.
class SpreadDirections {
 public:
  SpreadDirections(std::uint32_t column, std::uint32_t row) {
    const std::uint64_t seed = mixed((std::uint64_t{row} << 32) + column);
    first_[0] = share_of(seed), first_[1] = share_of(mixed(seed));
  }

  /// Returns direction number `sample` about a unit normal: a unit vector on the normal's side.
  /// Directions have a cosine-weighted distribution.
  Vec3 about(const Vec3& normal, int sample) const {
    double x, y;
    const double radius_square = point(sample, x, y), radius = std::sqrt(radius_square);
    return lifted(normal, radius * x, radius * y, std::sqrt(1 - radius_square));
  }

  /// Returns direction number `sample` in a cone about a unit vector: a unit vector. Directions are
  /// uniform over the cone.
  /// @param cap_height  1 - the cosine of half the angle at the cone's tip, from 0 to 1
  Vec3 within(const Vec3& axis, double cap_height, int sample) const {
    double x, y;
    const double below = point(sample, x, y) * cap_height, radius = std::sqrt(below * (2 - below));
    return lifted(axis, radius * x, radius * y, 1 - below);
  }

 private:
  /// Point number `sample` of the unit square, returned as a share of an area and a unit vector.
  double point(int sample, double& x, double& y) const {
    constexpr double step[2] = {0.7548776662466927, 0.5698402909980532};
    find_unit_vector(fraction(first_[1] + (sample + 0.5) * step[1]), x, y);
    return fraction(first_[0] + (sample + 0.5) * step[0]);
  }

  /// Transforms from a frame about a unit vector, without a division by a small number (Duff et al.
  /// 2017).
  static Vec3 lifted(const Vec3& axis, double x, double y, double z) {
    const double sign = std::copysign(1.0, axis.z), a = -1 / (sign + axis.z), b = axis.x * axis.y * a;
    const Vec3 across(1 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        along(b, sign + axis.y * axis.y * a, -axis.y);
    return x * across + y * along + z * axis;
  }

  static std::uint64_t mixed(std::uint64_t number) {
    number += 0x9e3779b97f4a7c15;
    number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9;
    number = (number ^ (number >> 27)) * 0x94d049bb133111eb;
    return number ^ (number >> 31);
  }

  /// The upper bits as a number in [0, 1).
  static double share_of(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

  static double fraction(double number) { return number - std::floor(number); }

  /// sin(pi / 2 x) for x in [-1, 1] by its series; the error is at most 4e-6.
  static double sine_of_quarter_turns(double x) {
    const double s = x * x;
    return x *
           (1.5707963267948966 -
            s * (0.6459640975062462 - s * (0.0796926262461670 - s * (0.0046817541353187 - s * 0.0001604411847874))));
  }

  static void find_unit_vector(double turn, double& x, double& y) {
    const double quarters = 4 * turn - 2;                        // [-2, 2)
    const double folded = 1 - std::abs(std::abs(quarters) - 1);  // [0, 1]: distance from the x axis
    const double cosine = sine_of_quarter_turns(std::abs(quarters) - 1), sine = sine_of_quarter_turns(folded);
    const double length = std::sqrt(cosine * cosine + sine * sine);
    x = cosine / length, y = (quarters < 0 ? -sine : sine) / length;
  }

  double first_[2];
};

}  // namespace rhoray::render
