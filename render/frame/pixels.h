#pragma once

#include "render/effects/effects.h"
#include "render/frame/pixel_rays.h"
#include "render/frame/tiles.h"
#include "render/frame/worker.h"
#include "render/framebuffer.h"
#include "render/kernels/hit_lookup.h"

namespace rhoray::render {

/// How hits are made into pixels; chosen once for a frame.
struct Look {
  const Layer& layer;
  Vec3 background;
  EffectSet effects;
  Facing facing;
  bool proves;                        ///< hits carry bounds of their errors
  const HitLookup* lookup = nullptr;  ///< where effects ask for more than hits say
  Machine machine = chosen_machine();
};

/// Colours of the hits of a worker's batch, and their counts. The same numbers on every machine.
void shade_tile(const Look& look, Worker& worker);

/// Asks for the memory into which a tile will be written while others work at it; changes nothing.
void expect_tile(const PixelLattice& lattice, const Tile& tile, const Framebuffer& out);

/// Writes a tile's colours, and of its hits what the framebuffer has channels for. A pixel of a lattice with a spacing
/// also stands for its neighbours to the right and below, up to the next pixel of the lattice.
void write_tile(const Look& look, const PixelLattice& lattice, const Tile& tile, const Worker& worker,
                Framebuffer& out);

}  // namespace rhoray::render
