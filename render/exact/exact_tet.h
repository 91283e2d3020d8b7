#pragma once

#include <array>
#include <cstdint>

#include "formats/base/vector.h"

namespace rhoray::render {

/// A tetrahedron with a value at each vertex, between which the field is linear. The vertices may
/// be in any order.
struct ExactTet {
  std::array<Vec3, 4> point;
  std::array<double, 4> value;
  std::uint64_t id = 0;
};

}  // namespace rhoray::render
