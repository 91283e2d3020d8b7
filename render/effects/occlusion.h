#pragma once

#include <cmath>
#include <cstdint>

#include "formats/base/vector.h"
#include "render/effects/lanes.h"

/// Ambient light that surfaces nearby hold back.
namespace rhoray::render {

/// The ambient light of the hits of a group, darkened.
/// @param shares  of it that reach the hits
RHORAY_INLINE void darken_ambient(const float* shares, Lanes& ambient) {
  for (std::size_t i = 0; i < ambient.size(); ++i) ambient[i] *= shares[i];
}

/// In which directions a pixel asks for what holds light back: about a normal, as many as the cosine weighs. Those of a
/// pixel are the points of Roberts' R2 sequence (multiples of the inverse plastic number and its square), moved around
/// by an amount that SplitMix64 makes of the pixel's place, on a disk that is lifted to the hemisphere. They depend on
/// nothing else, and only operations are used that IEEE 754 rounds exactly.
class OcclusionDirections {
 public:
  OcclusionDirections(std::uint32_t column, std::uint32_t row) {
    const std::uint64_t seed = mixed((std::uint64_t{row} << 32) + column);
    first_[0] = share_of(seed), first_[1] = share_of(mixed(seed));
  }

  /// Direction number `sample` about a unit normal: a unit vector on the normal's side.
  Vec3 about(const Vec3& normal, int sample) const {
    constexpr double step[2] = {0.7548776662466927, 0.5698402909980532};
    const double radius_square = fraction(first_[0] + (sample + 0.5) * step[0]),
                 turn = fraction(first_[1] + (sample + 0.5) * step[1]);
    double x, y;
    find_unit_vector(turn, x, y);
    const double radius = std::sqrt(radius_square), height = std::sqrt(1 - radius_square);
    // A frame about the normal without a division by a small number (Duff et al. 2017).
    const double sign = std::copysign(1.0, normal.z), a = -1 / (sign + normal.z), b = normal.x * normal.y * a;
    const Vec3 across(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        along(b, sign + normal.y * normal.y * a, -normal.y);
    return radius * x * across + radius * y * along + height * normal;
  }

 private:
  static std::uint64_t mixed(std::uint64_t number) {
    number += 0x9e3779b97f4a7c15;
    number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9;
    number = (number ^ (number >> 27)) * 0x94d049bb133111eb;
    return number ^ (number >> 31);
  }

  /// The upper bits, as a number from 0 to below 1.
  static double share_of(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

  static double fraction(double number) { return number - std::floor(number); }

  /// sin(pi / 2 x) for x in [-1, 1], up to 4e-6: the series.
  static double sine_of_quarter_turns(double x) {
    const double s = x * x;
    return x *
           (1.5707963267948966 -
            s * (0.6459640975062462 - s * (0.0796926262461670 - s * (0.0046817541353187 - s * 0.0001604411847874))));
  }

  static void find_unit_vector(double turn, double& x, double& y) {
    const double quarters = 4 * turn - 2;                        // [-2, 2)
    const double folded = 1 - std::abs(std::abs(quarters) - 1);  // [0, 1]: how far from the x axis
    const double cosine = sine_of_quarter_turns(std::abs(quarters) - 1), sine = sine_of_quarter_turns(folded);
    const double length = std::sqrt(cosine * cosine + sine * sine);
    x = cosine / length, y = (quarters < 0 ? -sine : sine) / length;
  }

  double first_[2];
};

}  // namespace rhoray::render
