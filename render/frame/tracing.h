#pragma once

#include "render/frame/frame.h"

/// Intersects a tile's rays with the layers of a frame, one layer after another.
namespace rhoray::render {

/// Makes the rays of every layer, finds the first surface or the largest value on them, and selects
/// the nearest opaque surface. Nothing behind that surface is traced.
void trace_layers(const Frame& frame, const LatticeRays& rays, const Tile& tile, Worker& worker);

}  // namespace rhoray::render
