#pragma once

#include "render/query/intersectors.h"

namespace rhoray::render::triangles {

/// For surfaces of triangles.
Intersectors intersectors(const VolumeImplementation& volume, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::triangles
