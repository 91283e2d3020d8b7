#pragma once

#include <array>
#include <optional>

#include "render/traverse/ray.h"

namespace rhoray::tests {

/// The tetrahedron test of the paper's Appendix B: the ray meets the isoplane at one t, which
/// counts when all four barycentric coordinates there are at least zero. Kept here as the naive
/// method for which the hard cases are hard.
inline std::optional<double> strict_crossing(const std::array<Vec3, 4>& p, const std::array<double, 4>& value,
                                             double iso, const render::Ray& ray) {
  // Barycentric coordinate i is normal_i . x + offset_i.
  std::array<Vec3, 4> normal;
  std::array<double, 4> offset;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 &a = p[(i + 1) % 4], &b = p[(i + 2) % 4], &c = p[(i + 3) % 4];
    normal[i] = (b - a).cross(c - a);
    normal[i] /= normal[i].dot(p[i] - a);
    offset[i] = -normal[i].dot(a);
  }
  Vec3 gradient(0, 0, 0);
  double constant = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    gradient += value[i] * normal[i];
    constant += value[i] * offset[i];
  }
  const double slope = gradient.dot(ray.direction);
  const double t = (iso - constant - gradient.dot(ray.origin)) / slope;
  const Vec3 hit = ray.at(t);
  for (std::size_t i = 0; i < 4; ++i)
    if (!(normal[i].dot(hit) + offset[i] >= 0)) return std::nullopt;
  return t;
}

}  // namespace rhoray::tests
