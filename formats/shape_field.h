#pragma once

#include <string_view>

namespace rhoray::formats {

/// The field by which packing shows a mesh that brings none: the distance of its points to its
/// boundary.
inline constexpr std::string_view boundary_distance = "boundary_distance";

/// The share of its largest value at which the mesh's shape is drawn; the smaller, the nearer to
/// the boundary.
inline constexpr double shape_share_of_distance = 0.0001;

}  // namespace rhoray::formats
