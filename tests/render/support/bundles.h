#pragma once

#include <vector>

#include "tests/render/support/rays.h"

namespace rhoray::tests {

/// Returns squares of 8 x 8 rays from points around and inside a box [0, size] towards points in
/// it; each square starts at one point or is parallel.
inline std::vector<render::Ray> bundles(const Vec3& size, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<render::Ray> rays;
  while (rays.size() < count) {
    const Vec3 target = dice.point({0, 0, 0}, size);
    Vec3 towards = dice.direction();
    if (dice.below(4) == 0) {
      const int axis = static_cast<int>(dice.below(3));
      towards = Vec3(0);
      towards[axis] = dice.coin() ? 1 : -1;
    }
    const double back = dice.between(0.1, 3) * size.length(), spread = dice.between(0.01, 8);
    const Vec3 u = towards.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = towards.cross(u);
    const bool is_parallel = dice.below(4) == 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec3 shift = spread * ((x - 3.5) / 4 * u + (y - 3.5) / 4 * v), eye = target - back * towards;
        rays.push_back({.origin = is_parallel ? eye + shift : eye,
                        .direction = is_parallel ? towards : (target + shift - eye).normalized()});
      }
  }
  return rays;
}

}  // namespace rhoray::tests
