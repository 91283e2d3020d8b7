#pragma once

#include "render/query/ordered_crossings.h"

namespace rhoray::render::wide {

/// All crossings of one or two isosurfaces of a uniform dense grid without gaps, for groups of rays at once; null where
/// there is no such kernel. First crossings are those of first_crossing_kernel, bit for bit.
CrossingsKernel shells_kernel(const VolumeImplementation& volume, const Question& question, Machine machine);

}  // namespace rhoray::render::wide
