#pragma once

#include <array>
#include <cstddef>

#include "render/triangles/facet_block.h"

namespace rhoray::render {

/// A tree of boxes around blocks of facets.
BoxLevels levels_above(const FacetBlock* blocks, std::size_t count);

/// The box around everything in a tree; an empty one where there is nothing.
struct FloatBox {
  std::array<float, 3> low, high;
};
FloatBox box_of(const BoxLevels& levels);

}  // namespace rhoray::render
