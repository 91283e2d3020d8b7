#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "formats/base/vector.h"
#include "render/traverse/ray.h"

namespace rhoray::tests {

/// Samples of a grid as a function of their positions.
using Samples = std::function<double(const Index3&)>;

/// Independent implementation of the trilinear interpolant: long double, weights at all eight
/// corners.
inline long double interpolated(const Samples& samples, const Index3& cell, const Vec3& p) {
  long double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const Index3 corner(cell.x + (c & 1), cell.y + (c >> 1 & 1), cell.z + (c >> 2 & 1));
    long double weight = 1;
    for (int axis = 0; axis < 3; ++axis)
      weight *= 1 - std::abs(static_cast<long double>(p[axis]) - static_cast<long double>(corner[axis]));
    if (weight != 0) sum += weight * static_cast<long double>(samples(corner));
  }
  return sum;
}

/// Returns the cell that contains a point; the last one for points in the far faces.
inline Index3 cell_of(const Vec3& p, const Index3& cell_count) {
  Index3 cell;
  for (int axis = 0; axis < 3; ++axis)
    cell[axis] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(p[axis])), 0, cell_count[axis] - 1);
  return cell;
}

/// Returns the part of a ray in a box, by slabs; nothing when it is shorter than 1e-9.
inline std::optional<std::array<double, 2>> part_in_box(const render::Ray& ray, const Vec3& low, const Vec3& high) {
  double t_in = ray.t_min, t_out = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0) {
      if (ray.origin[axis] < low[axis] || ray.origin[axis] > high[axis]) return std::nullopt;
      continue;
    }
    const double a = (low[axis] - ray.origin[axis]) / ray.direction[axis];
    const double b = (high[axis] - ray.origin[axis]) / ray.direction[axis];
    t_in = std::max(t_in, std::min(a, b));
    t_out = std::min(t_out, std::max(a, b));
  }
  if (!(t_out - t_in > 1e-9)) return std::nullopt;
  return std::array{t_in, t_out};
}

/// Positions of samples along the axes; an empty axis stands for 0, 1, 2, ...
using Axes = std::array<std::vector<double>, 3>;

inline Vec3 position_of(const Axes& axes, const Index3& sample) {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& table = axes[static_cast<std::size_t>(axis)];
    p[axis] = table.empty() ? static_cast<double>(sample[axis]) : table[static_cast<std::size_t>(sample[axis])];
  }
  return p;
}

/// Converts a point to a cell's local coordinates plus the cell's index.
inline Vec3 in_samples(const Axes& axes, const Index3& cell, const Vec3& p) {
  const Vec3 low = position_of(axes, cell), high = position_of(axes, cell + Index3(1, 1, 1));
  Vec3 at;
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = static_cast<double>(cell[axis]) + (p[axis] - low[axis]) / (high[axis] - low[axis]);
  return at;
}

/// Returns the largest value along a ray by testing every cell, using the cubic through four points
/// of its chord.
/// @param faces_only  tests only the chord's ends
inline std::optional<double> largest_by_brute_force(const Samples& samples, const Index3& cell_count,
                                                    const render::Ray& ray, bool faces_only = false,
                                                    const Axes& axes = {}) {
  std::optional<double> largest;
  const auto take = [&](long double value) {
    largest = std::max(largest.value_or(-1e300), static_cast<double>(value));
  };
  for (std::int64_t k = 0; k < cell_count.z; ++k)
    for (std::int64_t j = 0; j < cell_count.y; ++j)
      for (std::int64_t i = 0; i < cell_count.x; ++i) {
        const Index3 cell(i, j, k);
        const auto part = part_in_box(ray, position_of(axes, cell), position_of(axes, cell + Index3(1, 1, 1)));
        if (!part) continue;
        const auto value_at = [&](double s) {
          return interpolated(samples, cell, in_samples(axes, cell, ray.at((1 - s) * (*part)[0] + s * (*part)[1])));
        };
        const long double f0 = value_at(0), f1 = value_at(1.0 / 3), f2 = value_at(2.0 / 3), f3 = value_at(1);
        if (std::isnan(static_cast<double>(f0 + f1 + f2 + f3))) continue;  // a corner without data
        take(f0);
        take(f3);
        if (faces_only) continue;
        // Powers of s of the cubic through (0, f0), (1/3, f1), (2/3, f2), (1, f3).
        const long double c1 = -5.5L * f0 + 9 * f1 - 4.5L * f2 + f3;
        const long double c2 = 9 * f0 - 22.5L * f1 + 18 * f2 - 4.5L * f3;
        const long double c3 = -4.5L * f0 + 13.5L * f1 - 13.5L * f2 + 4.5L * f3;
        const long double root = std::sqrt(std::max(0.0L, 4 * c2 * c2 - 12 * c1 * c3));
        for (const long double s : {(-2 * c2 + root) / (6 * c3), (-2 * c2 - root) / (6 * c3), -c1 / (2 * c2)})
          if (s > 0 && s < 1) take(f0 + s * (c1 + s * (c2 + s * c3)));
      }
  return largest;
}

}  // namespace rhoray::tests
