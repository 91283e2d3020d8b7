#pragma once

#include <cstdint>

#include "rhoray/export.h"

namespace rhoray::RHORAY_ABI {

/// A point, a direction, or a colour in linear RGB. Points are in world axes and in the length unit
/// of the data.
struct Vec3 {
  double x = 0, y = 0, z = 0;

  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

/// A box along the world axes. It is empty if a component of `min` is above that of `max`.
struct Box3 {
  Vec3 min, max;

  friend constexpr bool operator==(const Box3&, const Box3&) = default;
};

/// The numbers from lo to hi, both included.
struct Interval {
  double lo = 0, hi = 0;

  friend constexpr bool operator==(const Interval&, const Interval&) = default;
};

/// The map p -> origin + p.x * x_axis + p.y * y_axis + p.z * z_axis. Variables are named
/// target_from_source.
struct Affine {
  Vec3 x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1}, origin{};

  friend constexpr bool operator==(const Affine&, const Affine&) = default;
};

/// The side of a plane to which its normal points, including the plane.
struct HalfSpace {
  Vec3 point{};
  Vec3 normal{};  ///< of any length but 0; must be set
};

/// The size of a picture in pixels.
struct Size {
  int width = 960, height = 720;

  friend constexpr bool operator==(const Size&, const Size&) = default;
};

/// Pixels of a picture. Pixel (0, 0) is the upper left corner.
struct Rect {
  int x = 0, y = 0;  ///< the first column and row
  int width = 0, height = 0;

  friend constexpr bool operator==(const Rect&, const Rect&) = default;
};

}  // namespace rhoray::RHORAY_ABI
