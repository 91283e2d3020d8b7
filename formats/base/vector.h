#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathVec.h>

#include <cstdint>

namespace rhoray {

/// A point or a direction. Variable names include the frame (p_grid, ray_world).
using Vec3 = Imath::V3d;

/// An index into, or the size of, a three-dimensional array; x varies fastest in memory.
using Index3 = Imath::Vec3<std::int64_t>;

using Box3 = Imath::Box3d;

/// Number of entries of an array of this size. The caller must have checked that it fits
/// (formats/base/bytes.h).
constexpr std::int64_t volume(const Index3& size) {
  return size.x * size.y * size.z;
}

}  // namespace rhoray
