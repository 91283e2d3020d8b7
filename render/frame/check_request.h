#pragma once

#include <span>

#include "render/render.h"

namespace rhoray::render {

/// Refuses what `render` says that it refuses, except for fields that colour layers, which are
/// looked up for layers in view (ErrorCode::usage).
void check_request(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options);

/// Refuses another spacing than Refinement::first_spacing allows (ErrorCode::usage).
void check_refinement(const Refinement& refinement);

/// True if every layer's method proves its hits.
bool all_prove(const Scene& scene);

}  // namespace rhoray::render
