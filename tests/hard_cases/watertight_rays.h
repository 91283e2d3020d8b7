#pragma once

#include <vector>

#include "tools/lab/closed_scenes.h"

namespace rhoray::tests {

/// Rays at a closed isosurface for which the parity of side changes is known. In the frame of the
/// scene's volume.
struct WatertightRays {
  std::vector<render::Ray> through;      ///< begin and end outside: even number of side changes
  std::vector<render::Ray> from_inside;  ///< begin inside: odd number of side changes
  std::vector<render::Ray> past;         ///< pass through the volume, but not through the surface
};

/// Makes rays aimed according to `aim`; `past` is not aimed. Half of `through` consists of squares
/// of 64 neighbouring rays, which wide kernels trace as groups; the other half comes from
/// study::ray_at.
/// @param count  total number of rays, a multiple of 256: 5 of 8 go through, 2 begin inside, 1 goes
///   past
WatertightRays watertight_rays(const study::ClosedScene& scene, study::Aim aim, std::size_t count, study::Dice& dice);

}  // namespace rhoray::tests
