#pragma once

#include "render/frame/frame.h"

/// What a tile's rays meet of the layers of a frame, one layer after another.
namespace rhoray::render {

/// Makes the rays of every layer, asks for the first surface or the largest value on them, and finds out which opaque
/// surface is the nearest: nothing is asked about behind it.
void trace_layers(const Frame& frame, const LatticeRays& rays, const Tile& tile, Worker& worker);

/// Asks about the parts of rays behind what the clip region cuts away, WorldRays::cut.
/// @param ends  of all rays of the tile; null: they do not end
void ask_behind_cut(const FrameLayer& layer, Kernel kernel, const Question& question, const double* ends,
                    Worker& worker, LayerWork& work);

}  // namespace rhoray::render
