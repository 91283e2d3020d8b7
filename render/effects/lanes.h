#pragma once

#include <array>
#include <cstdint>

#include "render/kernels/batch.h"

namespace rhoray::render {

/// One number of each hit of a group: effects are loops over such arrays, which gcc makes wide. They use operations
/// that IEEE 754 rounds exactly and no others, so a picture is the same on every machine.
struct alignas(64) Lanes : std::array<float, RayBatch::group_size> {};

/// Linear RGB of the hits of a group.
struct Colors {
  Lanes red, green, blue;
};

}  // namespace rhoray::render
