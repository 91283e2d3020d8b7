#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"

namespace rhoray::tools {

/// What somebody may not have meant of a scene's lights, one sentence each: lights that do not shine, that stand inside
/// opaque surfaces or behind all that is seen, that have a size but cast no shadows, and surfaces that nothing lights.
///
/// A light is taken to stand inside where each of 26 rays from it meets an opaque surface, and the ray to the eye too.
/// That holds for any field, whichever of its sides is solid, and for triangles; where data end, or where a surface has
/// a gap, a light inside may go unnoticed.
std::vector<std::string> light_notes(const render::Scene& scene, std::span<const render::Volume> volumes);

}  // namespace rhoray::tools
