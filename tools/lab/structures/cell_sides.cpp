#include "tools/lab/structures/cell_sides.h"

#include <algorithm>
#include <cmath>

namespace rhoray::study {

CellSides::CellSides(const std::array<std::array<double, 3>, 4>& points) {
  const auto point = [&](std::size_t v) { return Vec3(points[v][0], points[v][1], points[v][2]); };
  std::size_t n = 0;
  const auto add = [&](const Vec3& direction) {
    x_[n] = direction.x, y_[n] = direction.y, z_[n] = direction.z;
    size_x_[n] = std::abs(direction.x), size_y_[n] = std::abs(direction.y), size_z_[n] = std::abs(direction.z);
    const auto [lo, hi] = std::minmax(
        {direction.dot(point(0)), direction.dot(point(1)), direction.dot(point(2)), direction.dot(point(3))});
    lo_[n] = lo, hi_[n] = hi;
    ++n;
  };
  const std::array<Vec3, 3> axes{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  for (const Vec3& axis : axes) add(axis);
  for (std::size_t v = 0; v < 4; ++v) {
    const Vec3 corner = point((v + 1) % 4);
    add((point((v + 2) % 4) - corner).cross(point((v + 3) % 4) - corner));
  }
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b)
      for (const Vec3& axis : axes) add(axis.cross(point(b) - point(a)));
}

bool CellSides::touches(const Vec3& center, const Vec3& half) const {
  // Rounding of positions reaches 1e-9 of the smallest queried box.
  const Vec3 reach = half * (1 + 2e-6);
  int is_apart = 0;  // a number, to avoid branches
  for (std::size_t n = 0; n < count; ++n) {
    const double middle = x_[n] * center.x + y_[n] * center.y + z_[n] * center.z;
    const double radius = size_x_[n] * reach.x + size_y_[n] * reach.y + size_z_[n] * reach.z;
    is_apart |= int{middle + radius < lo_[n]} | int{middle - radius > hi_[n]};
  }
  return is_apart == 0;
}

}  // namespace rhoray::study
