#pragma once

#include "render/query/intersectors.h"

namespace rhoray::render::grid {

/// For grids of all kinds, NanoVDB's included.
Intersectors intersectors(const LoadedDataset& dataset, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::grid
