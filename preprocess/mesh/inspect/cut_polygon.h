#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::preprocess {

/// Cuts a polygon into corner count - 2 triangles between its own corners, which turn as it does. Where it is simple in
/// its projection along its mean normal's largest component, they do not overlap there.
/// @param corners  at least three, in order round it
/// @return         positions of corners
std::vector<std::array<std::size_t, 3>> cut_polygon(std::span<const Vec3> corners);

}  // namespace rhoray::preprocess
