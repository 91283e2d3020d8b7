#pragma once

#include <string_view>

namespace rhoray::formats {

/// Name of the field that packing adds to a mesh without fields: the distance of each point to the
/// mesh's boundary.
inline constexpr std::string_view boundary_distance = "boundary_distance";

/// Isovalue that shows the mesh's shape, as a share of the field's largest value. The smaller it
/// is, the closer the surface is to the boundary.
inline constexpr double shape_share_of_distance = 0.0001;

}  // namespace rhoray::formats
