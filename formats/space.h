#pragma once

#include <optional>
#include <string_view>

#include "formats/base/affine.h"

namespace rhoray::formats {

/// A frame of world coordinates in a patient's body.
enum class Space {
  unknown,
  ras,  ///< x to the patient's right, y to the front (anterior), z to the head (superior)
  lps   ///< x to the patient's left, y to the back (posterior), z to the head
};

/// "RAS", "LPS"; empty for unknown.
constexpr std::string_view space_word(Space space) {
  return space == Space::ras ? "RAS" : space == Space::lps ? "LPS" : "";
}

/// Nothing for another word.
constexpr std::optional<Space> space_named(std::string_view word) {
  for (const Space space : {Space::unknown, Space::ras, Space::lps})
    if (word == space_word(space)) return space;
  return std::nullopt;
}

/// The same map into another space; unchanged where either is unknown. Exact: only signs change.
inline Affine in_space(Affine world_from_data, Space from, Space to) {
  if (from == to || from == Space::unknown || to == Space::unknown) return world_from_data;
  for (Vec3* vector :
       {&world_from_data.x_axis, &world_from_data.y_axis, &world_from_data.z_axis, &world_from_data.origin})
    *vector = Vec3(-vector->x, -vector->y, vector->z);
  return world_from_data;
}

}  // namespace rhoray::formats
