#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "preprocess/neutral.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {

inline preprocess::NeutralSurface surface_of(const std::vector<Vec3>& points,
                                             const std::vector<std::vector<std::uint64_t>>& facets) {
  preprocess::NeutralSurface surface;
  for (const Vec3& p : points) surface.points.push_back(to_array(p));
  for (const auto& facet : facets) {
    surface.facet_corners.insert(surface.facet_corners.end(), facet.begin(), facet.end());
    surface.facet_offsets.push_back(surface.facet_corners.size());
  }
  return surface;
}

/// The cube from 0 to 1, of six squares or twelve triangles, counter-clockwise seen from outside.
inline preprocess::NeutralSurface cube_surface(bool of_triangles = true) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1, i >> 1 & 1, i >> 2 & 1);
  std::vector<std::vector<std::uint64_t>> facets{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                 {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  if (!of_triangles) return surface_of(points, facets);
  std::vector<std::vector<std::uint64_t>> triangles;
  for (const auto& f : facets) {
    triangles.push_back({f[0], f[1], f[2]});
    triangles.push_back({f[0], f[2], f[3]});
  }
  return surface_of(points, triangles);
}

/// A closed surface around the origin: an octahedron whose triangles are split into four `depth`
/// times, 8 * 4^depth in total, with each point at radius(direction). Counter-clockwise seen from
/// outside.
inline preprocess::NeutralSurface round_surface(
    int depth, const std::function<double(const Vec3&)>& radius = [](const Vec3&) { return 1.0; }) {
  std::vector<Vec3> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::vector<std::uint64_t>> facets{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                 {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int d = 0; d < depth; ++d) {
    std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> middles;
    const auto middle = [&](std::uint64_t a, std::uint64_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), points.size());
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return found->second;
    };
    std::vector<std::vector<std::uint64_t>> finer;
    for (const auto& f : facets) {
      const std::uint64_t ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], ab, ca}, {ab, f[1], bc}, {ca, bc, f[2]}, {ab, bc, ca}});
    }
    facets = std::move(finer);
  }
  for (Vec3& p : points) p *= radius(p);
  return surface_of(points, facets);
}

/// Moves and scales every point: offset + scale * p.
inline preprocess::NeutralSurface moved(preprocess::NeutralSurface surface, const Vec3& offset, double scale = 1) {
  for (auto& p : surface.points) p = to_array(offset + scale * to_vec3(p));
  return surface;
}

}  // namespace rhoray::tests
