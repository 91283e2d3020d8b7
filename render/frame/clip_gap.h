#pragma once

#include "render/frame/frame.h"

namespace rhoray::render {

/// Traces the parts of rays behind the gap that the clip region cuts away (WorldRays::cut).
/// @param ends  end of each ray of the tile; null: the rays do not end
void trace_after_clip_gap(const FrameLayer& layer, Kernel kernel, const RayQuery& query, const double* ends,
                          Worker& worker, LayerWork& work);

}  // namespace rhoray::render
