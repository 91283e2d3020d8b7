#pragma once

#include "rhoray/scene.h"

namespace rhoray::v0_1::inside {

/// Refuses numbers of a scene that are out of range, with the layer, and layers that do not fit
/// their data. render::render checks lights, clip regions and the camera.
void check(const Scene& scene);

}  // namespace rhoray::v0_1::inside
