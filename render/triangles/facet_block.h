#pragma once

#include <cstdint>

#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Sixteen facets, side by side. A quadrilateral's corners stand in order round it; a triangle repeats its last one.
/// Beyond the last facet of all stands the last one again.
struct alignas(64) FacetBlock {
  static constexpr std::uint32_t size = 16;
  float corner[4][3][size];
};

using FacetNode = BoxNode;

/// The linear field of a facet's cell: value + gradient . (p - anchor), the isovalue subtracted; p in the mesh's frame.
/// Of a surface's triangle: zero in its plane, rising on the side on which its corners turn counter-clockwise.
struct FacetField {
  double gradient[3];
  double value;
  std::uint32_t cell;  ///< id
  std::uint32_t tet;   ///< position in the mesh, or of a surface's triangle
  float cell_size;     ///< the longest edge, mesh units
  float doubt;         ///< what rounding of the gradient puts the field off by inside the cell, at most; infinite where
                       ///< the cell is flat, or nearly, and the gradient says nothing
};

/// How far from a facet's corners a ray may pass that meets it, in the facets' frame: far above the rounding of
/// corners and of their places (place_error in kernels/facet_parts.h).
inline constexpr double facet_margin = 0x1p-18;

}  // namespace rhoray::render
