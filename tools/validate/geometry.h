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

/// Angle between a direction and that of the reference, in degrees: 180 if only the reference has a
/// direction, NaN if it has none.
inline double angle_deg(const Vec3& reference, const Vec3& found) {
  const auto is_direction = [](const Vec3& v) { return std::isfinite(v.length()) && v.length() > 0; };
  if (!is_direction(reference)) return std::numeric_limits<double>::quiet_NaN();
  if (!is_direction(found)) return 180;
  return std::atan2(reference.cross(found).length(), reference.dot(found)) * 180 / std::numbers::pi;
}

inline Vec3 to_vec3(const Index3& i) {
  return {static_cast<double>(i.x), static_cast<double>(i.y), static_cast<double>(i.z)};
}

}  // namespace rhoray::tools::validate
