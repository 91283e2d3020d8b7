#pragma once

#include "render/shade/lanes.h"

/// Ambient light that surfaces nearby hold back.
namespace rhoray::render {

/// The ambient light of the hits of a group, darkened.
/// @param shares  of it that reach the hits
RHORAY_INLINE void darken_ambient(const float* shares, Lanes& ambient) {
  for (std::size_t i = 0; i < ambient.size(); ++i) ambient[i] *= shares[i];
}

}  // namespace rhoray::render
