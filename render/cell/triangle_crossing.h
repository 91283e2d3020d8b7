#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "render/cell/tet_crossing.h"

namespace rhoray::render {

using TrianglePoints = std::array<std::array<double, 3>, 3>;

/// The normal of a triangle, towards the side from which its corners appear counter-clockwise; its
/// length is twice the area. Zero for a triangle without area.
RHORAY_INLINE Vec3 triangle_normal(const TrianglePoints& p) {
  const auto edge = [&](std::size_t to) { return Vec3(p[to][0] - p[0][0], p[to][1] - p[0][1], p[to][2] - p[0][2]); };
  return edge(1).cross(edge(2));
}

/// Where a ray's line passes through a triangle. This is decided by the exact signs of its edges in
/// the ray's picture plane (passes_left). So triangles that share an edge agree about it, whichever
/// way they traverse it. A closed surface is passed an even number of times.
/// @param ids  of the corners, all different; the same point must have the same id in all triangles
/// @return     t, in the range of the corners' t; nothing where the triangle is seen edge-on
RHORAY_INLINE std::optional<double> cross_triangle(const RayShear& shear, const TrianglePoints& points,
                                                   const std::array<std::uint32_t, 3>& ids) {
  const std::array<RayShear::Seen, 3> seen{shear.see(points[0]), shear.see(points[1]), shear.see(points[2])};
  const auto left = [&](std::size_t i, std::size_t j) {
    return ids[i] < ids[j] ? passes_left(seen[i], seen[j]) : !passes_left(seen[j], seen[i]);
  };
  const bool side = left(0, 1);
  if (left(1, 2) != side || left(2, 0) != side) return std::nullopt;
  double weight[3] = {edge_weight(seen[1], seen[2]), edge_weight(seen[2], seen[0]), edge_weight(seen[0], seen[1])};
  // Added so that exchanging the second and the third corner does not change t.
  double sum = weight[0] + (weight[1] + weight[2]);
  // Weights so small that the products vanish.
  if (!(sum > 0)) weight[0] = weight[1] = weight[2] = 1, sum = 3;
  const double t = (weight[0] * seen[0].t + (weight[1] * seen[1].t + weight[2] * seen[2].t)) / sum;
  const auto [least, most] = std::minmax({seen[0].t, seen[1].t, seen[2].t});
  return std::clamp(t, least, most);
}

}  // namespace rhoray::render
