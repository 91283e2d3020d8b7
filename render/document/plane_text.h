#pragma once

#include <string>

#include "formats/base/vector.h"
#include "render/clip.h"

namespace rhoray::render {

/// "z = 40", or "through (1, 2, 3) with normal (0, 1, 1)".
std::string text_of_slice(const HalfSpace& plane);

/// "the slice z = 999 lies outside the data (0 to 74)"; without the range for other normals.
std::string text_of_slice_outside(const HalfSpace& plane, const Box3& bounds);

}  // namespace rhoray::render
