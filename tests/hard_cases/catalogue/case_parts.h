#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "tests/hard_cases/catalogue/hard_case.h"
#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

/// Building blocks from which the families make their cases.
///
/// Two random numbers are never drawn as arguments of one function, nor as operands of one
/// operator: the language leaves their order open, and each compiler would trace other rays.
/// Members of a list in braces are drawn in order.
namespace rhoray::tests {

using Pack = std::function<std::unique_ptr<TracedDataset>()>;
using Rays = std::vector<render::Ray>;

inline constexpr double no_hit = std::numeric_limits<double>::infinity();

/// Why a direct method may err in a grid of whole numbers.
inline constexpr std::string_view ties_at_edges =
    "where a ray meets an edge of the lattice in a point whose value is the isovalue, rounding decides";

template <class T>
Pack grid_of(const Index3& count, std::function<T(const Index3&)> sample, const Affine& world_from_grid = {},
             const preprocess::PackVolumeOptions& options = {}) {
  return [=] { return std::make_unique<TracedDataset>(volume_of<T>(count, sample, world_from_grid), options); };
}

inline Pack mesh_of(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& options = {}) {
  return [=] { return std::make_unique<TracedDataset>(mesh, options); };
}

inline std::uint64_t hash_of(const Index3& at) {
  std::uint64_t h = static_cast<std::uint64_t>((at.z * 1009 + at.y) * 1013 + at.x + 1) * 0x9e3779b97f4a7c15U;
  h ^= h >> 29;
  return (h * 0xbf58476d1ce4e5b9U) >> 11;
}

/// A number in [0, 1) that tells nothing about those of its neighbours.
inline double noise(const Index3& at) {
  return static_cast<double>(hash_of(at)) * 0x1p-53;
}
/// A whole number in [0, count).
inline std::int64_t whole_noise(const Index3& at, std::int64_t count) {
  return static_cast<std::int64_t>(hash_of(at) % static_cast<std::uint64_t>(count));
}

inline Vec3 as_point(const Index3& at) {
  return {static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)};
}

/// Components are multiples of an eighth: computations with them and with lattice points are exact.
inline Vec3 direction_in_eighths(Dice& dice) {
  for (;;) {
    const Index3 d{dice.below(17) - 8, dice.below(17) - 8, dice.below(17) - 8};
    if (d != Index3(0, 0, 0)) return as_point(d) / 8;
  }
}

/// A ray that reaches a point at t = back, exactly where the numbers allow it.
inline render::Ray through(const Vec3& target, const Vec3& direction, double back) {
  return {.origin = target - back * direction, .direction = direction};
}

/// Rays from outside through any points of a box [0, size].
inline Rays random_rays(const Vec3& size, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const Vec3 target = dice.point({0, 0, 0}, size), direction = dice.direction();
    rays.push_back(through(target, direction, 2 * size.length()));
  }
  return rays;
}

/// Rays that meet faces, edges or corners of the lattice, in exact numbers.
/// @param whole_axes  number of axes on which the target point lies in a lattice plane: 1 a face, 2
///   an edge, 3 a corner
inline Rays aimed_rays(const Vec3& size, int whole_axes, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    Vec3 target;
    const auto first_broken = dice.below(3);
    for (int n = 0; n < 3; ++n) {
      const int a = static_cast<int>((first_broken + n) % 3);
      const double units = n < 3 - whole_axes ? 64 : 1;
      target[a] = static_cast<double>(dice.below(static_cast<std::int64_t>(size[a] * units) + 1)) / units;
    }
    rays.push_back(through(target, direction_in_eighths(dice), 64));
  }
  return rays;
}

inline Rays together(std::vector<Rays> parts) {
  Rays rays;
  for (const Rays& part : parts) rays.insert(rays.end(), part.begin(), part.end());
  return rays;
}

/// Random rays, and equal numbers of rays at faces, edges and corners: half of them in total.
inline Rays all_kinds_of_rays(const Vec3& size, std::size_t count, std::uint64_t seed) {
  const std::size_t part = count / 6;
  return together({random_rays(size, count - 3 * part, seed), aimed_rays(size, 1, part, seed + 1),
                   aimed_rays(size, 2, part, seed + 2), aimed_rays(size, 3, part, seed + 3)});
}

/// Returns the rays for which `wanted` is true.
template <class Wanted>
Rays only(Rays rays, Wanted&& wanted) {
  std::erase_if(rays, [&](const render::Ray& ray) { return !wanted(ray); });
  return rays;
}

/// Where a ray first changes its side at a plane across the box [0, size] of samples. The field of
/// the plane is slope . p, the isovalue its height. Returns nothing for rays that nearly lie in the
/// plane or meet it near the border.
inline KnownAnswer plane_in_box(const Vec3& slope, const Vec3& size) {
  return [=](const render::Ray& ray, double isovalue) -> std::optional<double> {
    const double rise = slope.dot(ray.direction);
    if (std::abs(rise) < 1e-3 * slope.length() * ray.direction.length()) return std::nullopt;
    const double t = (isovalue - slope.dot(ray.origin)) / rise;
    const auto part = part_in_box(ray, {0, 0, 0}, size);
    const double margin = 1e-6 / ray.direction.length();
    if (!part) return part_in_box(ray, Vec3(-1e-6), size + Vec3(1e-6)) ? std::nullopt : std::optional(no_hit);
    if (std::abs(t - (*part)[0]) < margin || std::abs(t - (*part)[1]) < margin) return std::nullopt;
    return t > (*part)[0] && t < (*part)[1] ? t : no_hit;
  };
}

/// Where a ray from outside enters a closed box. Returns nothing for rays that come near its edges.
inline KnownAnswer entry_into(const Vec3& low, const Vec3& high) {
  return [=](const render::Ray& ray, double) -> std::optional<double> {
    const Vec3 near(1e-6);
    const auto part = part_in_box(ray, low, high), inner = part_in_box(ray, low + near, high - near);
    if (inner) return (*part)[0];
    return part_in_box(ray, low - near, high + near) ? std::nullopt : std::optional(no_hit);
  };
}

inline std::optional<double> never(const render::Ray&, double) {
  return no_hit;
}

}  // namespace rhoray::tests
