#pragma once

#include "render/shade/lanes.h"
#include "render/shade/texture_lookup.h"

namespace rhoray::render {

/// Composites a texture's colours over those of a surface.
RHORAY_INLINE void cover(const CoveringColors& texture, Colors& colors) {
  for (std::size_t i = 0; i < colors.red.size(); ++i) {
    const float seen = 1 - texture.share[i];
    colors.red[i] = texture.red[i] + seen * colors.red[i];
    colors.green[i] = texture.green[i] + seen * colors.green[i];
    colors.blue[i] = texture.blue[i] + seen * colors.blue[i];
  }
}

}  // namespace rhoray::render
