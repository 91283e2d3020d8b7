#pragma once

#include "render/query/intersectors.h"

namespace rhoray::render::tets {

/// For meshes of tetrahedra.
Intersectors intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::tets
