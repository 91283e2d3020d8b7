#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "preprocess/mesh/subdivide/shape_functions.h"

namespace rhoray::preprocess {

/// Local coordinates in a cell in steps of 2^-14.
using FinePlace = std::array<std::uint16_t, 3>;
inline constexpr double fine_steps = 16384;

inline FinePlace fine(const CellPlace& place) {
  FinePlace result;
  for (std::size_t axis = 0; axis < 3; ++axis)
    result[axis] = static_cast<std::uint16_t>(std::lround(place[axis] * fine_steps));
  return result;
}

inline CellPlace coarse(const FinePlace& place) {
  return {place[0] / fine_steps, place[1] / fine_steps, place[2] / fine_steps};
}

inline FinePlace middle(const FinePlace& a, const FinePlace& b) {
  FinePlace result;
  for (std::size_t axis = 0; axis < 3; ++axis) result[axis] = static_cast<std::uint16_t>((a[axis] + b[axis]) / 2);
  return result;
}
}  // namespace rhoray::preprocess
