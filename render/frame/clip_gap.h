#pragma once

#include "render/frame/frame.h"

namespace rhoray::render {

/// Asks about the parts of rays behind what the clip region cuts away, WorldRays::cut.
/// @param ends  of all rays of the tile; null: they do not end
void ask_behind_cut(const FrameLayer& layer, Kernel kernel, const Question& question, const double* ends,
                    Worker& worker, LayerWork& work);

}  // namespace rhoray::render
