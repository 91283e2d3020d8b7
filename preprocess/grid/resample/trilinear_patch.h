#pragma once

#include <array>
#include <cstddef>

namespace rhoray::preprocess {

/// A corner of a polygon in a cell's local coordinates (0 to 1 on every axis), with a value.
struct PatchPoint {
  std::array<double, 3> at;
  double value;
};

/// The part of a triangle that lies in the unit cube; values are linear in the triangle. It has at
/// most nine corners, except for rounding.
class ClippedTriangle {
 public:
  explicit ClippedTriangle(const std::array<PatchPoint, 3>& triangle);

  std::size_t size() const { return size_; }  ///< corners; fewer than three when nothing is left
  const PatchPoint& operator[](std::size_t i) const { return corners_[i]; }

 private:
  void clip(std::size_t axis, double sign, double place);

  /// Half as many again for each of six sides: more than rounding can make of three.
  static constexpr std::size_t capacity = 28;

  std::array<PatchPoint, capacity> corners_;
  std::size_t size_ = 3;
};

/// Bounds of |trilinear - linear| on a triangle inside a cell.
struct PatchBounds {
  double upper;     ///< not exceeded anywhere on the triangle
  double attained;  ///< at the worst of its corners
  std::array<double, 3> at;
};

/// The difference restricted to a triangle is a cubic. The largest of its ten Bernstein
/// coefficients bounds it, and three of them are its values at the corners. The coefficients come
/// from the polar form of a trilinear function T. It is the mean of T(x of one, y of another, z of
/// the third) over the six ways to assign three points to the three axes.
/// @param corners  the trilinear function at the cell's corners, x fastest
PatchBounds patch_bounds(const std::array<PatchPoint, 3>& triangle, const std::array<double, 8>& corners);

}  // namespace rhoray::preprocess
