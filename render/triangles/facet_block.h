#pragma once

#include <cstdint>

#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Sixteen facets, side by side. A quadrilateral's corners are in order around it; a triangle
/// repeats its last corner. The last block is filled up with copies of the last facet.
struct alignas(64) FacetBlock {
  static constexpr std::uint32_t size = 16;
  float corner[4][3][size];
};

using FacetNode = BoxNode;

/// The linear field of a facet's cell: value + gradient . (p - anchor), with the isovalue
/// subtracted; p in the mesh's frame. For a triangle of a surface: zero in its plane, increasing
/// towards the side from which its corners are counter-clockwise.
struct FacetField {
  double gradient[3];
  double value;
  std::uint32_t cell;  ///< id
  std::uint32_t tet;   ///< index in the mesh, or of the triangle in a surface
  float cell_size;     ///< the longest edge, mesh units
  /// Upper bound of the error of the field inside the cell caused by rounding the gradient.
  /// Infinite for a cell that is flat or nearly flat, where the gradient is meaningless.
  float doubt;
};

/// Maximum distance from a facet's corners at which a ray that hits it may pass, in the facets'
/// frame. Far above the rounding of corners and of their positions (place_error in
/// kernels/facet_parts.h).
inline constexpr double facet_margin = 0x1p-18;

}  // namespace rhoray::render
