#pragma once

#include <array>
#include <cstddef>

#include "render/triangles/facet_block.h"

namespace rhoray::render {

/// Builds a tree of boxes over blocks of facets.
BoxLevels levels_above(const FacetBlock* blocks, std::size_t count);

/// The box around a whole tree; empty for an empty tree.
struct FloatBox {
  std::array<float, 3> low, high;
};
FloatBox box_of(const BoxLevels& levels);

}  // namespace rhoray::render
