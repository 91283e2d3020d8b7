#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

namespace rhoray::preprocess {

/// False for NaN and infinity: cells that touch such a value are absent.
template <class T>
bool has_data(T value) {
  if constexpr (std::is_floating_point_v<T>)
    return std::abs(value) <= std::numeric_limits<T>::max();
  else
    return true;
}

}  // namespace rhoray::preprocess
