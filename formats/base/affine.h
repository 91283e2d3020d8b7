#pragma once

#include "formats/base/vector.h"

namespace rhoray {

/// An affine map p -> origin + p.x * x_axis + p.y * y_axis + p.z * z_axis. Variables are named
/// target_from_source. The axes may be rotated, sheared or mirrored; only a map with linearly
/// independent axes has an inverse.
struct Affine {
  Vec3 x_axis{1, 0, 0};
  Vec3 y_axis{0, 1, 0};
  Vec3 z_axis{0, 0, 1};
  Vec3 origin{0, 0, 0};

  Vec3 point(const Vec3& p) const { return origin + vector(p); }
  Vec3 vector(const Vec3& v) const { return v.x * x_axis + v.y * y_axis + v.z * z_axis; }

  /// Volume of the image of the unit cube; negative when the map mirrors.
  double determinant() const { return x_axis.dot(y_axis.cross(z_axis)); }

  /// Transforms a gradient from the source frame to the target frame (inverse transpose).
  Vec3 gradient(const Vec3& g) const {
    return (g.x * y_axis.cross(z_axis) + g.y * z_axis.cross(x_axis) + g.z * x_axis.cross(y_axis)) / determinant();
  }

  /// Returns source_from_target. The determinant must not be zero.
  Affine inverse() const {
    const double det = determinant();
    const Vec3 row_x = y_axis.cross(z_axis) / det, row_y = z_axis.cross(x_axis) / det,
               row_z = x_axis.cross(y_axis) / det;
    Affine inv{{row_x.x, row_y.x, row_z.x}, {row_x.y, row_y.y, row_z.y}, {row_x.z, row_y.z, row_z.z}, {0, 0, 0}};
    inv.origin = -inv.vector(origin);
    return inv;
  }

  friend bool operator==(const Affine&, const Affine&) = default;
};

/// p -> a(b(p)).
inline Affine composed(const Affine& a, const Affine& b) {
  return {a.vector(b.x_axis), a.vector(b.y_axis), a.vector(b.z_axis), a.point(b.origin)};
}

}  // namespace rhoray
