#pragma once

#include "render/frame/frame.h"

/// Which light reaches what is seen: rays from hits, asked about in batches.
namespace rhoray::render {

/// Notes which pixels a tile's rays stand for, on which directions into the surroundings depend.
void number_pixels(const PixelLattice& lattice, const Tile& tile, Worker& worker);

/// Whether a layer's effects ask for anything of the light that reaches its hits.
bool asks_for_light(const FrameLayer& layer);

/// Finds out, for the hits of a layer, what its effects ask for of the light that reaches them: into Worker::received.
/// To be asked before the hits are shaded, which may take the place of their gradients.
///
/// Rays start in the hits, on the side of the surface that the eye sees, and know it: so they meet neither the crossing
/// that they start in nor one beside it, and need no distance to be safe from it. A ray towards a light is asked about
/// only where the light stands on that side of the surface; where it does not, none of it is received. The surface's
/// own gradient decides, smooth normals or not. Of a light that has a size rays go to points spread over it, as far as
/// they stand on that side, and what is received is the share of those that reach it. Rays are answered at the default
/// level of the volume, whatever the layer's method.
/// @param shown  which rays show this layer; null: all that have hit it
void receive_light(const Frame& frame, std::uint8_t layer, const LayerOfRays* shown, Worker& worker);

}  // namespace rhoray::render
