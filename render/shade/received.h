#pragma once

#include <algorithm>
#include <vector>

#include "render/shade/lanes.h"

namespace rhoray::render {

/// What of the light that is sent to them reaches the hits of a batch, from 0 to 1. Only what the frame has asked about
/// has numbers: where there are none, all of it does.
struct ReceivedLight {
  std::vector<LaneArray<float>> of_lights;  ///< by light
  LaneArray<float> ambient;

  /// Shares of a light for the hits of a group.
  RHORAY_INLINE void find_shares(std::size_t light, std::size_t first, Lanes& shares) const {
    const float* of_light = of_lights[light].data();
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = of_light[first + i];
  }
};

}  // namespace rhoray::render
