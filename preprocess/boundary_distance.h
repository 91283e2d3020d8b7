#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The distance of each point to the nearest of the triangles (exact up to rounding; they are searched through a tree
/// of boxes, on all cores). Corners of triangles have 0. Expects finite corners of triangles, at least one triangle; a
/// point that is not finite has a distance that is not.
Array<double> distances_to(std::span<const std::array<std::uint64_t, 3>> triangles,
                           std::span<const std::array<double, 3>> points);

}  // namespace rhoray::preprocess
