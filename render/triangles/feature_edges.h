#pragma once

#include <array>
#include <vector>

#include "render/triangles/triangle_data.h"

namespace rhoray::render {

/// The ends of the edges at which a surface turns by more than an angle (Dataset::feature_edges),
/// in the frame of the triangles. A triangle without area has no angle to others: its edges count
/// as flat.
/// @param threads  0 = all cores; the result is the same for any number
std::vector<std::array<Vec3, 2>> feature_edges(const TriangleData& view, double angle_deg, unsigned threads);

double area_of(const TriangleData& view);

}  // namespace rhoray::render
