#pragma once

#include "render/frame/frame.h"

namespace rhoray::render {

/// Asks about the parts of rays behind what the clip region cuts away, WorldRays::cut.
/// @param ends  of all rays of the tile; null: they do not end
void trace_after_clip_gap(const FrameLayer& layer, Kernel kernel, const RayQuery& query, const double* ends,
                          Worker& worker, LayerWork& work);

}  // namespace rhoray::render
