#pragma once

#include <array>

#include "formats/base/vector.h"

namespace rhoray {

/// The corners of a box; x alternates fastest, from low to high.
inline std::array<Vec3, 8> corners_of(const Box3& box) {
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = {(i & 1) != 0 ? box.max.x : box.min.x, (i & 2) != 0 ? box.max.y : box.min.y,
                  (i & 4) != 0 ? box.max.z : box.min.z};
  return corners;
}

}  // namespace rhoray
