#pragma once

#include "render/frame/frame.h"

/// Computes which light reaches visible surfaces, with batches of rays from the hits.
namespace rhoray::render {

/// Notes which pixels a tile's rays belong to. The directions of occlusion and soft-shadow rays
/// depend on them.
void number_pixels(const PixelLattice& lattice, const Tile& tile, Worker& worker);

/// True if a layer's effects depend on the light that reaches its hits.
bool asks_for_light(const FrameLayer& layer);

/// Computes the light that reaches a layer's hits, as far as its effects need it, and stores it in
/// Worker::received. Call it before the hits are shaded, because shading may overwrite their
/// gradients.
///
/// Rays start at the hits and know the side of the surface that the eye sees. So they intersect
/// neither the crossing at which they start nor one beside it, and need no offset. A ray towards a
/// light is traced only if the light is in front of that side of the surface; otherwise no light is
/// received. The surface's own gradient decides this, even with smooth normals. For an area light,
/// rays go to points spread over it, as far as they are in front of the surface. The light received
/// is the share of rays that reach it. Rays are traced at the dataset's default accuracy, whatever
/// the layer's method.
/// @param shown  the layer that each ray shows; null: all rays with a hit on this layer
void receive_light(const Frame& frame, std::uint8_t layer, const LayerOfRays* shown, Worker& worker);

}  // namespace rhoray::render
