#pragma once

#include <array>
#include <cstdint>

#include "render/query/batch.h"

namespace rhoray::render {

/// One number for each hit of a group. Effects are loops over such arrays, which gcc vectorizes.
/// They use only operations that IEEE 754 rounds exactly, so a picture is the same on every
/// machine.
struct alignas(64) Lanes : std::array<float, RayBatch::group_size> {};

/// Unit vectors for the hits of a group, world axes.
struct Directions {
  Lanes x, y, z;
};

RHORAY_INLINE void find_cosines(const Directions& a, const Directions& b, Lanes& cosines) {
  for (std::size_t i = 0; i < cosines.size(); ++i) cosines[i] = a.x[i] * b.x[i] + a.y[i] * b.y[i] + a.z[i] * b.z[i];
}

/// Linear RGB of the hits of a group.
struct Colors {
  Lanes red, green, blue;
};

RHORAY_INLINE void fill_colors(const Imath::V3f& color, Colors& colors) {
  colors.red.fill(color.x), colors.green.fill(color.y), colors.blue.fill(color.z);
}

}  // namespace rhoray::render
