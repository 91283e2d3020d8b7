#pragma once

#include "tools/study/peers/embree.h"

namespace rhoray::study {

/// Embree over boxes of tetrahedra, with callbacks that look for the isosurface inside them: over the cells that an
/// isovalue crosses, built for every isovalue, or over all cells, built once.
std::shared_ptr<EmbreeScene> embree_cells(bool only_crossed);

}  // namespace rhoray::study
