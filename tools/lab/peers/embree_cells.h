#pragma once

#include "tools/lab/peers/embree.h"

namespace rhoray::study {

/// How the callback treats the 16 rays of a packet that reach a cell's box. Either one formula for
/// all of them, compiled for the processor's widest instructions, or one ray after the other, in
/// plain C++ for every x86-64 processor.
enum class CellCallback { sixteen_rays, ray_by_ray };

/// Embree over boxes of tetrahedra, with callbacks that intersect the isosurface inside them.
/// Either over the cells that an isovalue crosses, built for every isovalue, or over all cells,
/// built once.
std::shared_ptr<EmbreeScene> embree_cells(bool only_crossed, CellCallback callback);

}  // namespace rhoray::study
