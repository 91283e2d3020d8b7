#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>

#include "formats/base/vector.h"

namespace rhoray::tests {

/// Exact arithmetic, as reference for decisions in floating point.
using Rational = boost::multiprecision::cpp_rational;

/// Returns exactly the value of a double.
inline Rational exact(double x) {
  return Rational(x);
}

struct ExactVec3 {
  Rational x, y, z;

  friend ExactVec3 operator-(const ExactVec3& a, const ExactVec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  Rational dot(const ExactVec3& o) const { return x * o.x + y * o.y + z * o.z; }
  ExactVec3 cross(const ExactVec3& o) const { return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x}; }
};

inline ExactVec3 exact(const Vec3& p) {
  return {exact(p.x), exact(p.y), exact(p.z)};
}
inline ExactVec3 exact(const std::array<double, 3>& p) {
  return {exact(p[0]), exact(p[1]), exact(p[2])};
}

/// -1, 0 or 1.
inline int sign_of(const Rational& x) {
  return x < 0 ? -1 : x > 0 ? 1 : 0;
}

inline double rounded(const Rational& x) {
  return x.convert_to<double>();
}

}  // namespace rhoray::tests
