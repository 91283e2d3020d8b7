#pragma once

#include <array>
#include <utility>

#include "formats/base/checks.h"

namespace rhoray {

/// Sorts four numbers in increasing order with five comparisons, the minimum possible.
template <class T>
RHORAY_INLINE std::array<T, 4> rising(std::array<T, 4> v) {
  if (v[1] < v[0]) std::swap(v[0], v[1]);
  if (v[3] < v[2]) std::swap(v[2], v[3]);
  if (v[2] < v[0]) std::swap(v[0], v[2]);
  if (v[3] < v[1]) std::swap(v[1], v[3]);
  if (v[2] < v[1]) std::swap(v[1], v[2]);
  return v;
}

}  // namespace rhoray
