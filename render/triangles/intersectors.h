#pragma once

#include "render/query/intersectors.h"

namespace rhoray::render::triangles {

/// For surfaces of triangles.
Intersectors intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::triangles
