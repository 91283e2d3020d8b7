#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "preprocess/neutral.h"

namespace rhoray::tests {

/// Colours given by a function of their lattice index. Do not copy the result: its span would refer
/// to the original.
/// @param texel  red, green, blue and alpha; the first component_count are kept
inline preprocess::NeutralVolume colors_of(const Index3& count, int component_count,
                                           const std::function<std::array<std::uint8_t, 4>(const Index3&)>& texel,
                                           const Affine& world_from_grid = {}) {
  preprocess::NeutralVolume made;
  made.sample_count = count;
  made.component_count = component_count;
  made.type = formats::ElementType::U8;
  made.world_from_grid = world_from_grid;
  made.field_name = "colors";
  for (Index3 at{0, 0, 0}; at.z < count.z; ++at.z)
    for (at.y = 0; at.y < count.y; ++at.y)
      for (at.x = 0; at.x < count.x; ++at.x) {
        const std::array<std::uint8_t, 4> components = texel(at);
        for (std::size_t c = 0; c < static_cast<std::size_t>(component_count); ++c)
          made.owned_samples.push_back(static_cast<std::byte>(components[c]));
      }
  made.samples = made.owned_samples;
  return made;
}

/// Colours that are unique in small lattices and encode their index.
inline std::array<std::uint8_t, 4> telling_texel(const Index3& at) {
  return {static_cast<std::uint8_t>(at.x + 1), static_cast<std::uint8_t>(100 + at.y),
          static_cast<std::uint8_t>(200 + at.z), static_cast<std::uint8_t>(17 * at.x)};
}

}  // namespace rhoray::tests
