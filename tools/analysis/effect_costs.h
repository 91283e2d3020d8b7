#pragma once

#include <string_view>
#include <vector>

#include "render/resolved_scene.h"

namespace rhoray::tools {

/// A scene without one of the effects that it uses.
struct WithoutEffect {
  std::string_view effect;  ///< as in "antialiasing"
  render::ResolvedScene plan;
};

/// For each effect that a scene uses and can be without, the scene without it. What an effect costs
/// is how much less time that picture takes. It can be negative: clipping also removes work.
std::vector<WithoutEffect> without_each_effect(const render::ResolvedScene& plan);

}  // namespace rhoray::tools
