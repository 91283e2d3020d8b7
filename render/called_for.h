#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "render/load.h"
#include "render/render.h"
#include "render/scene.h"

namespace rhoray::render {

/// An effect, whether a layer calls for it, and why.
struct EffectReason {
  std::string_view effect;
  bool called_for = false;
  std::string why;  ///< "specular is 0.25"
};

/// Every effect there is, asked of a layer in its scene: what the frame computes is decided by the same function.
std::vector<EffectReason> reasons_for_effects(const Scene& scene, const Layer& layer);

/// What the kernel that answers a layer's rays is compiled for: scalar, baseline, avx2 or avx512.
std::string_view machine_for(const Volume& volume, const Layer& layer, const FrameOptions& options);

}  // namespace rhoray::render
