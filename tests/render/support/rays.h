#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "render/traverse/ray.h"

namespace rhoray::tests {

/// Pseudorandom numbers with a fixed seed.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::int64_t below(std::int64_t count) { return std::uniform_int_distribution<std::int64_t>(0, count - 1)(random_); }
  bool coin() { return below(2) == 0; }
  template <class T, std::size_t n>
  T one_of(const std::array<T, n>& of) {
    return of[static_cast<std::size_t>(below(static_cast<std::int64_t>(n)))];
  }
  Vec3 point(const Vec3& low, const Vec3& high) {
    return {between(low.x, high.x), between(low.y, high.y), between(low.z, high.z)};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 d = point({-1, -1, -1}, {1, 1, 1});
      if (d.length2() > 0.01 && d.length2() <= 1) return d.normalized();
    }
  }

 private:
  std::mt19937_64 random_;
};

/// Returns rays through a box [0, size] that stress a traversal. Directions are arbitrary and
/// special (zero, -0, denormal, tiny and huge components, diagonals through lattice points).
/// Origins are inside, on planes and lattice points, near and far; some rays are cut short.
inline std::vector<render::Ray> stressful_rays(const Vec3& size, std::size_t count, std::uint64_t seed) {
  constexpr std::array<double, 10> special{0.0, -0.0, 1.0, -1.0, 0.5, -2.0, 1e-310, -1e-14, 1e-5, 3.0};
  constexpr std::array<double, 5> distances{0.0, 1.0, 100.0, 1e6, 1e9};
  constexpr std::array<double, 5> lengths{1.0, 1.0, 1e-20, 1e20, 3.7};
  Dice dice(seed);
  std::vector<render::Ray> rays;
  while (rays.size() < count) {
    Vec3 direction = dice.direction();
    if (dice.below(3) == 0)
      direction = {dice.one_of(special), dice.one_of(special), dice.one_of(special)};
    else if (dice.below(4) == 0)
      for (int axis = 0; axis < 3; ++axis)
        if (dice.coin()) direction[axis] = dice.one_of(special);
    if (direction.length() < 1e-3) continue;

    Vec3 through = dice.point({0, 0, 0}, size);
    for (int axis = 0; axis < 3; ++axis) {
      if (dice.below(4) == 0) through[axis] = std::round(through[axis]);
      if (dice.below(12) == 0) through[axis] = dice.coin() ? 0 : size[axis];
    }
    render::Ray ray;
    ray.direction = direction * dice.one_of(lengths);
    ray.origin = through - (dice.one_of(distances) / direction.length()) * direction;
    // From lattice point to lattice point, all numbers exact: many planes at once.
    if (dice.below(6) == 0) {
      constexpr std::array<double, 4> steps{1.0, -1.0, 2.0, -0.5};
      ray.direction = {dice.one_of(steps), dice.one_of(steps), dice.one_of(steps)};
      for (int axis = 0; axis < 3; ++axis) through[axis] = std::round(through[axis]);
      ray.origin = through - static_cast<double>(4 * dice.below(8)) * ray.direction;
    }
    if (dice.below(5) == 0) ray.t_min = dice.between(0, 2 * size.length()) / ray.direction.length();
    if (dice.below(5) == 0) ray.t_max = ray.t_min + dice.between(0, 2 * size.length()) / ray.direction.length();
    rays.push_back(ray);
  }
  return rays;
}

}  // namespace rhoray::tests
