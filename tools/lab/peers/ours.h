#pragma once

#include "tools/lab/peers/peer.h"

namespace rhoray::study {

/// `render` at one level: "preview", "float", "double", "certified" or "exact".
PeerPointer own_isosurface(const std::string& level);
PeerPointer own_largest_values(const std::string& level);

}  // namespace rhoray::study
