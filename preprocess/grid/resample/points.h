#pragma once

#include <array>
#include <cmath>

namespace rhoray::preprocess {

/// A point or a direction, in the mesh's frame or in steps of a lattice.
using Point = std::array<double, 3>;

inline Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double sum_of_magnitudes(const Point& a) {
  return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]);
}

/// By value: std::min and std::max of references become branches here, which are mispredicted half
/// of the time.
template <class T>
T smaller(T a, T b) {
  return a < b ? a : b;
}
template <class T>
T larger(T a, T b) {
  return a > b ? a : b;
}

}  // namespace rhoray::preprocess
