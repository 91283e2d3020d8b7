#pragma once

#include <algorithm>

#include "render/exact/enclosure.h"

namespace rhoray::render {

/// The uncertainty of the position of an exactly decided crossing: about a millionth of a millionth
/// of a cell.
inline constexpr double exact_width_cells = 0x1p-40;

/// The number that stands for an enclosure, and a bound on its distance from the exact one.
struct Middle {
  double value, error;
  explicit Middle(const Enclosure& enclosure)
      : value(0.5 * enclosure.lo + 0.5 * enclosure.hi),
        error(std::max(value - enclosure.lo, enclosure.hi - value) * (1 + 0x1p-50)) {}
};

}  // namespace rhoray::render
