#pragma once

#include <algorithm>
#include <array>

#include "formats/base/checks.h"

namespace rhoray {

/// Sorts four numbers in increasing order with five comparisons, the minimum possible. Minima
/// and maxima need no branches, which a processor could not predict for random numbers.
template <class T>
RHORAY_INLINE std::array<T, 4> rising(const std::array<T, 4>& v) {
  const T low_01 = std::min(v[0], v[1]), high_01 = std::max(v[0], v[1]);
  const T low_23 = std::min(v[2], v[3]), high_23 = std::max(v[2], v[3]);
  const T second = std::max(low_01, low_23), third = std::min(high_01, high_23);
  return {std::min(low_01, low_23), std::min(second, third), std::max(second, third), std::max(high_01, high_23)};
}

}  // namespace rhoray
