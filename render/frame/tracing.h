#pragma once

#include "render/frame/frame.h"

/// What a tile's rays meet of the layers of a frame, one layer after another.
namespace rhoray::render {

/// Makes the rays of every layer, asks for the first surface or the largest value on them, and finds out which opaque
/// surface is the nearest: nothing is asked about behind it.
void trace_layers(const Frame& frame, const LatticeRays& rays, const Tile& tile, Worker& worker);

}  // namespace rhoray::render
