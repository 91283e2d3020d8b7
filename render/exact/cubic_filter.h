#pragma once

#include <optional>

#include "render/exact/ball.h"

namespace rhoray::render {

/// What double precision can say for certain about the roots of a cubic in [0, 1]; none of them at 0 or 1, all simple.
struct CertainRoots {
  int count = 0;
  int sign_at_0 = 0;  ///< 1 or -1
  Enclosure first{};  ///< holds the first root and no other; the cubic has opposite signs at its ends
};

/// Nothing when a sign is in doubt.
/// @param width  asks for this width of the first root's enclosure; what can not be had for certain stays wider
std::optional<CertainRoots> certain_roots(const BallCubic& cubic, double width);

/// The largest value on [0, 1], always.
Enclosure largest_value_enclosure(const BallCubic& cubic);

struct CertainMaximum {
  Enclosure value;
  Enclosure s;  ///< holds the smallest place where it is reached
};

/// Nothing when it is in doubt where the maximum lies, within `width`.
std::optional<CertainMaximum> certain_maximum(const BallCubic& cubic, double width);

}  // namespace rhoray::render
