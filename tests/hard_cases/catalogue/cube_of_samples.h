#pragma once

#include "tests/hard_cases/catalogue/case_parts.h"

/// The grid of most cases of family R.
namespace rhoray::tests {

inline constexpr std::int64_t edge = 10;  // samples per axis, unless a case sets another number
inline const Index3 cube(edge, edge, edge);
inline const Vec3 size(edge - 1);
inline constexpr double middle = 4.5;  // coordinate of the cube's centre

inline Pack whole_number_noise() {
  return grid_of<std::uint8_t>(cube, [](const Index3& at) { return static_cast<std::uint8_t>(whole_noise(at, 5)); });
}
inline Pack smooth_noise() {
  return grid_of<float>(cube, [](const Index3& at) { return static_cast<float>(noise(at)); });
}

/// A block with value 5, smaller values around it.
inline Pack block() {
  return grid_of<std::uint8_t>(cube, [](const Index3& at) {
    const bool in_block = std::min({at.x, at.y, at.z}) >= 3 && std::max({at.x, at.y, at.z}) <= 6;
    return static_cast<std::uint8_t>(in_block ? 5 : whole_noise(at, 4));
  });
}

}  // namespace rhoray::tests
