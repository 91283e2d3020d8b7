#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"

namespace rhoray::render {

/// Notes about lights that are probably a mistake, one sentence each: lights without intensity,
/// inside opaque surfaces or behind everything visible, lights with a size that cast no shadows,
/// and surfaces without any light.
///
/// A light counts as inside if each of 26 rays from it hits an opaque surface, and the ray to the
/// camera too. This holds for any field, whichever side is solid, and for triangles. At the end of
/// the data, or where a surface has a gap, a light inside may not be noticed.
std::vector<std::string> light_notes(const Scene& scene, std::span<const Dataset> datasets);

}  // namespace rhoray::render
