#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "formats/base/vector.h"
#include "render/ray_caster.h"

namespace rhoray::tools::validate {

/// The tracer to be validated: traces rays in the data's frame. Tests pass wrong tracers.
using Tracer = std::function<void(std::span<const render::Ray> rays, std::span<render::Hit> hits)>;

/// Receives the progress in thousandths.
using Thousandths = std::function<void(std::uint64_t done)>;

/// Triangles in the data's frame.
struct Triangles {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> corners;

  Vec3 corner(std::size_t triangle, std::size_t c) const { return points[corners[triangle][c]]; }
  Vec3 center(std::size_t triangle) const {
    return (corner(triangle, 0) + corner(triangle, 1) + corner(triangle, 2)) / 3.0;
  }
  /// Not of unit length; zero if the triangle has no area.
  Vec3 normal(std::size_t triangle) const {
    const Vec3 a = corner(triangle, 0);
    return (corner(triangle, 1) - a).cross(corner(triangle, 2) - a);
  }
};

/// Angle between two directions in degrees; NaN if one of them has no direction.
inline double angle_deg(const Vec3& a, const Vec3& b) {
  const auto is_direction = [](const Vec3& v) { return std::isfinite(v.length()) && v.length() > 0; };
  if (!is_direction(a) || !is_direction(b)) return std::numeric_limits<double>::quiet_NaN();
  return std::atan2(a.cross(b).length(), a.dot(b)) * 180 / std::numbers::pi;
}

inline Vec3 to_vec3(const Index3& i) {
  return {static_cast<double>(i.x), static_cast<double>(i.y), static_cast<double>(i.z)};
}

}  // namespace rhoray::tools::validate
