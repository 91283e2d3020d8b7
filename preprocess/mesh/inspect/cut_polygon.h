#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::preprocess {

/// Cuts a polygon into corner count - 2 triangles between its own corners, with the polygon's
/// winding. Where the polygon is simple in its projection along its mean normal's largest
/// component, the triangles do not overlap there.
/// @param corners  at least three, in order around the polygon
/// @return         indices into `corners`
std::vector<std::array<std::size_t, 3>> cut_polygon(std::span<const Vec3> corners);

}  // namespace rhoray::preprocess
