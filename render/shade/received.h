#pragma once

#include <algorithm>
#include <vector>

#include "render/shade/lanes.h"

namespace rhoray::render {

/// Light that reaches the hits of a batch, as shares from 0 to 1 of the light sent to them. There
/// are numbers only for what the frame has traced. Without numbers, all of the light arrives.
struct ReceivedLight {
  std::vector<LaneArray<float>> of_lights;  ///< by light
  LaneArray<float> ambient;

  /// Copies a light's shares for the hits of a group.
  RHORAY_INLINE void find_shares(std::size_t light, std::size_t first, Lanes& shares) const {
    const float* of_light = of_lights[light].data();
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = of_light[first + i];
  }
};

}  // namespace rhoray::render
