#pragma once

#include "render/shade/lanes.h"

/// Ambient light that nearby surfaces occlude.
namespace rhoray::render {

/// Darkens the ambient light of a group's hits.
/// @param shares  of the ambient light that reach the hits
RHORAY_INLINE void darken_ambient(const float* shares, Lanes& ambient) {
  for (std::size_t i = 0; i < ambient.size(); ++i) ambient[i] *= shares[i];
}

}  // namespace rhoray::render
