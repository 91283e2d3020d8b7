#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace rhoray {

/// The values from lo to hi, both included. Starts empty (lo > hi); NaN is never included.
template <class T>
struct Interval {
  static constexpr T lowest() {
    if constexpr (std::numeric_limits<T>::has_infinity)
      return -std::numeric_limits<T>::infinity();
    else
      return std::numeric_limits<T>::lowest();
  }
  static constexpr T highest() {
    if constexpr (std::numeric_limits<T>::has_infinity)
      return std::numeric_limits<T>::infinity();
    else
      return std::numeric_limits<T>::max();
  }

  T lo = highest();
  T hi = lowest();

  constexpr bool is_empty() const { return lo > hi; }
  constexpr bool contains(T value) const { return lo <= value && value <= hi; }

  constexpr void include(T value) {
    if (value < lo) lo = value;  // written so that a NaN changes nothing
    if (value > hi) hi = value;
  }
  constexpr void include(const Interval& other) {
    lo = std::min(lo, other.lo);
    hi = std::max(hi, other.hi);
  }

  friend constexpr bool operator==(const Interval&, const Interval&) = default;
};

}  // namespace rhoray
