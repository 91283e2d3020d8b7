#pragma once

#include <optional>

#include "render/exact/ball.h"

namespace rhoray::render {

/// What double precision proves about the roots of a cubic in [0, 1]; none of them at 0 or 1, all
/// simple.
struct CertainRoots {
  int count = 0;
  int sign_at_0 = 0;  ///< 1 or -1
  /// Contains the first root and no other; the cubic has opposite signs at its ends.
  Enclosure first{};
};

/// Returns nothing when a sign is in doubt.
/// @param width  requested width of the first root's enclosure; it stays wider where a smaller one
///   cannot be proven
std::optional<CertainRoots> certain_roots(const BallCubic& cubic, double width);

/// Encloses the largest value on [0, 1]; always succeeds.
Enclosure largest_value_enclosure(const BallCubic& cubic);

struct CertainMaximum {
  Enclosure value;
  Enclosure s;  ///< contains the smallest s at which it is reached
};

/// Returns nothing when the position of the maximum is in doubt, within `width`.
std::optional<CertainMaximum> certain_maximum(const BallCubic& cubic, double width);

}  // namespace rhoray::render
