#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/exact/exact_tets.h"
#include "tests/render/support/rays.h"

/// Small meshes in memory, and rays through their cells, faces, edges and vertices.
namespace rhoray::tests {

/// A block of n^3 cubes of six tetrahedra each around their diagonals, with vertices slightly moved
/// or not.
inline std::vector<render::ExactTet> block(int n, Dice& dice, double moved, const Vec3& at, bool whole_values) {
  const auto side = static_cast<std::size_t>(n + 1);
  std::vector<Vec3> points;
  std::vector<double> values;
  for (std::size_t v = 0; v < side * side * side; ++v) {
    const Vec3 p(static_cast<double>(v % side), static_cast<double>(v / side % side),
                 static_cast<double>(v / side / side));
    points.push_back(at + p + moved * dice.point({-1, -1, -1}, {1, 1, 1}));
    values.push_back(whole_values ? static_cast<double>(dice.below(5) - 2) : dice.between(-1, 1));
  }
  std::vector<render::ExactTet> tets;
  for (std::size_t cube = 0; cube < static_cast<std::size_t>(n * n * n); ++cube) {
    const std::size_t m = static_cast<std::size_t>(n);
    const std::size_t base = cube % m + side * (cube / m % m) + side * side * (cube / m / m);
    std::array<std::size_t, 3> steps{1, side, side * side};
    std::sort(steps.begin(), steps.end());
    do {
      const std::array<std::size_t, 4> v{base, base + steps[0], base + steps[0] + steps[1],
                                         base + steps[0] + steps[1] + steps[2]};
      render::ExactTet tet;
      for (std::size_t i = 0; i < 4; ++i) tet.point[i] = points[v[i]], tet.value[i] = values[v[i]];
      tet.id = tets.size();
      tets.push_back(tet);
    } while (std::next_permutation(steps.begin(), steps.end()));
  }
  return tets;
}

/// Returns a ray aimed at a point of any kind: of a cell, a face, an edge, a vertex; or along an
/// edge.
inline render::Ray aimed_ray(const std::vector<render::ExactTet>& tets, Dice& dice) {
  const render::ExactTet& tet = tets[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(tets.size())))];
  const std::int64_t corners = 1 + dice.below(4);
  Vec3 target(0, 0, 0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(corners); ++i)
    target += tet.point[i] / static_cast<double>(corners);
  render::Ray ray;
  ray.direction = dice.direction();
  if (dice.below(4) == 0) ray.direction = tet.point[1] - tet.point[0];
  if (dice.below(4) == 0)
    for (int axis = 0; axis < 3; ++axis) ray.direction[axis] = std::round(2 * ray.direction[axis]);
  if (ray.direction == Vec3(0, 0, 0)) ray.direction.x = 1;
  ray.origin = target - 8.0 * ray.direction;
  if (dice.below(3) == 0) ray.t_min = dice.between(6, 8);
  return ray;
}

}  // namespace rhoray::tests
