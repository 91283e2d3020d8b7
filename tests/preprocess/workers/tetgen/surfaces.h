#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::tests {

using preprocess::NeutralMesh;
using preprocess::NeutralSurface;
using Point = std::array<double, 3>;

inline void add_facet(NeutralSurface& surface, std::initializer_list<std::uint64_t> corners) {
  surface.facet_corners.insert(surface.facet_corners.end(), corners);
  surface.facet_offsets.push_back(surface.facet_corners.size());
}

/// The box [lo, hi] as twelve triangles; triangles 0 and 1 are its bottom.
inline void add_box(NeutralSurface& surface, const Point& lo, const Point& hi) {
  const std::uint64_t b = surface.points.size();
  for (std::size_t i = 0; i < 8; ++i)
    surface.points.push_back({i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]});
  for (const auto& q : std::vector<std::array<std::uint64_t, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    add_facet(surface, {b + q[0], b + q[1], b + q[2]});
    add_facet(surface, {b + q[0], b + q[2], b + q[3]});
  }
}

inline NeutralSurface box(const Point& lo, const Point& hi) {
  NeutralSurface surface;
  add_box(surface, lo, hi);
  return surface;
}

/// Prisms of height 1: their bottom and top are one facet each, of as many corners as the outline.
inline NeutralSurface prism(const std::vector<std::array<double, 2>>& outline) {
  NeutralSurface surface;
  const std::uint64_t n = outline.size();
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : outline) surface.points.push_back({x, y, z});
  for (std::uint64_t i = 0; i < n; ++i) surface.facet_corners.push_back(n - 1 - i);
  surface.facet_offsets.push_back(n);
  for (std::uint64_t i = 0; i < n; ++i) surface.facet_corners.push_back(n + i);
  surface.facet_offsets.push_back(2 * n);
  for (std::uint64_t i = 0; i < n; ++i) add_facet(surface, {i, (i + 1) % n, n + (i + 1) % n, n + i});
  return surface;
}

/// A square of side 2 without a quarter, beginning at one of its six corners; volume 3 as a prism.
inline std::vector<std::array<double, 2>> l_outline(std::ptrdiff_t first) {
  std::vector<std::array<double, 2>> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  std::rotate(outline.begin(), outline.begin() + first, outline.end());
  return outline;
}

/// Every facet cut into triangles that meet in its first corner, right or not.
inline NeutralSurface as_fans(const NeutralSurface& surface) {
  NeutralSurface fans;
  fans.points = surface.points;
  for (std::size_t f = 0; f + 1 < surface.facet_offsets.size(); ++f)
    for (std::uint64_t i = surface.facet_offsets[f] + 2; i < surface.facet_offsets[f + 1]; ++i)
      add_facet(fans, {surface.facet_corners[surface.facet_offsets[f]], surface.facet_corners[i - 1],
                       surface.facet_corners[i]});
  return fans;
}

/// A box of 3 x 3 x 1 with a tunnel of 1 x 1 through its middle. Its bottom and top are faces with
/// two outlines each; the inner outline is an opening. The volume is 8.
inline NeutralSurface tunnel() {
  NeutralSurface surface = prism({{0, 0}, {3, 0}, {3, 3}, {0, 3}});
  const NeutralSurface inner = prism({{1, 1}, {2, 1}, {2, 2}, {1, 2}});
  NeutralSurface all;
  all.points = surface.points;
  all.points.insert(all.points.end(), inner.points.begin(), inner.points.end());
  const auto add = [&](const NeutralSurface& from, std::size_t facet, std::uint64_t first_point, std::uint64_t face) {
    for (std::uint64_t i = from.facet_offsets[facet]; i < from.facet_offsets[facet + 1]; ++i)
      all.facet_corners.push_back(first_point + from.facet_corners[i]);
    all.facet_offsets.push_back(all.facet_corners.size());
    all.facet_faces.push_back(face);
  };
  std::uint64_t face = 0;
  for (std::size_t facet = 0; facet < 2; ++facet, ++face) {
    add(surface, facet, 0, face);
    add(inner, facet, surface.points.size(), face);
    all.openings.push_back({face, {1.5, 1.5, static_cast<double>(facet)}});
  }
  for (std::size_t facet = 2; facet < 6; ++facet) {
    add(surface, facet, 0, face++);
    add(inner, facet, surface.points.size(), face++);
  }
  return all;
}

/// An octahedron whose triangles are quartered `rounds` times, its points on the sphere.
inline void add_sphere(NeutralSurface& surface, double radius, int rounds, const Point& centre = {0, 0, 0}) {
  std::vector<Point> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<std::uint64_t, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int round = 0; round < rounds; ++round) {
    std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> middles;
    const auto middle = [&](std::uint64_t a, std::uint64_t b) {
      const auto [place, is_new] = middles.try_emplace(std::minmax({a, b}), points.size());
      if (is_new) {
        Point m{points[a][0] + points[b][0], points[a][1] + points[b][1], points[a][2] + points[b][2]};
        const double length = std::hypot(m[0], m[1], m[2]);
        for (double& x : m) x /= length;
        points.push_back(m);
      }
      return place->second;
    };
    std::vector<std::array<std::uint64_t, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint64_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  const std::uint64_t base = surface.points.size();
  for (const Point& p : points)
    surface.points.push_back({centre[0] + radius * p[0], centre[1] + radius * p[1], centre[2] + radius * p[2]});
  for (const auto& [a, b, c] : triangles) add_facet(surface, {base + a, base + b, base + c});
}

inline double determinant(const Point& a, const Point& b, const Point& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// Volume that the triangles [first, last) enclose, by the divergence theorem.
inline double enclosed_volume(const NeutralSurface& surface, std::size_t first, std::size_t last) {
  double volume = 0;
  for (std::size_t t = first; t < last; ++t) {
    const std::uint64_t* corner = surface.facet_corners.data() + surface.facet_offsets[t];
    volume += determinant(surface.points[corner[0]], surface.points[corner[1]], surface.points[corner[2]]) / 6;
  }
  return volume;
}

inline Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Positive when (p1-p0) x (p2-p0) . (p3-p0) is.
inline double cell_volume(const NeutralMesh& mesh, std::size_t cell) {
  const auto& c = mesh.cells[cell];
  const Point& o = mesh.points[c[0]];
  return determinant(minus(mesh.points[c[1]], o), minus(mesh.points[c[2]], o), minus(mesh.points[c[3]], o)) / 6;
}

}  // namespace rhoray::tests
