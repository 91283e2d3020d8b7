#pragma once

#include <memory>
#include <optional>

#include "render/frame/pixel_rays.h"
#include "render/frame/tiles.h"
#include "render/frame/worker.h"
#include "render/framebuffer.h"
#include "render/shade/effects.h"
#include "render/shade/hit_lookup.h"
#include "render/shade/texture_lookup.h"

namespace rhoray::render {

/// How a layer's hits are made into colours; chosen once for a frame.
struct LayerShading {
  const Layer& layer;
  EffectSet effects;
  Facing facing;
  LayerLights lights{};
  std::optional<Fog> fog{};
  bool proves;                                ///< hits carry bounds of their errors
  std::shared_ptr<const HitLookup> lookup{};  ///< where effects ask for more than hits say
  std::shared_ptr<const TextureLookup> texture{};
  Machine machine = chosen_machine();
};

// Colours of a tile's rays: the same numbers on every machine. What of the light reaches the hits is read where effects
// ask for it.

/// All of them the background's.
void fill_background(const Vec3& background, std::size_t count, TileColors& colors);

/// Those of all hits, over what is there.
void shade_hits(const LayerShading& shading, LayerWork& work, const ReceivedLight& received, WorkerCounts& counts,
                TileColors& colors);

/// Those of the hits that `shown` names, over what is there.
void shade_shown(const LayerShading& shading, LayerWork& work, const LayerOfRays& shown, std::uint8_t layer,
                 const ReceivedLight& received, WorkerCounts& counts, TileColors& colors);

/// Clear surfaces, from front to back: no light yet, and all that lies behind is seen.
void begin_front(std::size_t count, TileColors& front);
/// Adds the hits that `next` names, behind what has been added.
void shade_clear(const LayerShading& shading, LayerWork& work, const LayerOfRays& next, std::uint8_t layer,
                 const ReceivedLight& received, WorkerCounts& counts, TileColors& front);
/// Adds light of hits, each by its share, in any order.
/// @param shares  of the tile's rays; 0: not shown
void add_clear(const LayerShading& shading, LayerWork& work, const float* shares, const ReceivedLight& received,
               WorkerCounts& counts, LightSums& light);
/// The light that was added, as the light of `front`.
void put_into_front(const LightSums& light, std::size_t count, TileColors& front);
void put_in_front(const TileColors& front, std::size_t count, TileColors& colors);

/// Largest values as white light over what is there, which shows through as far as the grey of a projection by itself
/// is below white.
void composite_mip(const LayerShading& shading, LayerWork& work, const ReceivedLight& received, WorkerCounts& counts,
                   TileColors& colors);

/// Writes the colours of a tile's traced blocks. A pixel of a lattice with a spacing also stands for its neighbours to
/// the right and below, up to the next pixel of the lattice.
void write_colors(const PixelLattice& lattice, const Tile& tile, const TileColors& colors, Framebuffer& out,
                  Machine machine = chosen_machine());

/// Writes of a tile's hits what the framebuffer has channels for.
/// @param normals  of the hits: towards the eye, world axes; read where the framebuffer keeps them
void write_channels(const PixelLattice& lattice, const Tile& tile, const HitBatch& hits, const Vec3* normals,
                    Framebuffer& out);

/// Writes the other blocks' pixels: what is written of a ray that meets nothing and cost nothing.
void write_background(const Vec3& background, const PixelLattice& lattice, const Tile& tile, Framebuffer& out);

}  // namespace rhoray::render
