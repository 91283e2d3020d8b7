#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "render/load.h"
#include "render/render.h"
#include "render/scene.h"

namespace rhoray::render {

/// An effect, whether a layer needs it, and why.
struct EffectReason {
  std::string_view effect;
  bool called_for = false;
  std::string why;  ///< "specular is 0.25"
};

/// Lists every effect for a layer of a scene. The renderer decides with the same function what to
/// compute.
std::vector<EffectReason> reasons_for_effects(const Scene& scene, const Layer& layer);

/// Returns what the kernel that traces a layer's rays is compiled for: scalar, baseline, avx2 or
/// avx512.
std::string_view machine_for(const Dataset& dataset, const Layer& layer, const FrameOptions& options);

}  // namespace rhoray::render
