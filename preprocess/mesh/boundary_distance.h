#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Returns the distance of each point to the nearest triangle. It is exact up to rounding; a tree
/// of boxes is searched on all cores. Corners of triangles have distance 0. Expects at least one
/// triangle, and finite corners. The distance of a point that is not finite is not finite.
Array<double> distances_to(std::span<const std::array<std::uint64_t, 3>> triangles,
                           std::span<const std::array<double, 3>> points);

}  // namespace rhoray::preprocess
