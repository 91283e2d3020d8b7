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

/// How a layer's hits become colours; chosen once per frame.
struct LayerShading {
  const Layer& layer;
  EffectSet effects;
  Facing facing;
  LayerLights lights{};
  std::optional<Fog> fog{};
  bool proves;  ///< hits carry error bounds
  /// Null unless effects need more than the hits contain.
  std::shared_ptr<const HitLookup> lookup{};
  std::shared_ptr<const TextureLookup> texture{};
  Machine machine = chosen_machine();
};

// The functions below compute colours of a tile's rays. The numbers are the same on every machine.
// The light that reaches the hits is read only where effects need it.

/// Fills all colours with the background.
void fill_background(const Vec3& background, std::size_t count, TileColors& colors);

/// Composites all hits over the colours.
void shade_hits(const LayerShading& shading, LayerWork& work, const ReceivedLight& received, WorkerCounts& counts,
                TileColors& colors);

/// Composites the hits that `shown` selects over the colours.
void shade_shown(const LayerShading& shading, LayerWork& work, const LayerOfRays& shown, std::uint8_t layer,
                 const ReceivedLight& received, WorkerCounts& counts, TileColors& colors);

/// Starts front-to-back compositing of transparent surfaces: no light, full transmittance.
void begin_front(std::size_t count, TileColors& front);
/// Adds the hits that `next` selects behind those added so far.
void shade_clear(const LayerShading& shading, LayerWork& work, const LayerOfRays& next, std::uint8_t layer,
                 const ReceivedLight& received, WorkerCounts& counts, TileColors& front);
/// Adds the light of hits, each weighted by its share, in any order.
/// @param shares  for the tile's rays; 0: not shown
void add_clear(const LayerShading& shading, LayerWork& work, const float* shares, const ReceivedLight& received,
               WorkerCounts& counts, LightSums& light);
/// Stores the summed light as the light of `front`.
void put_into_front(const LightSums& light, std::size_t count, TileColors& front);
void put_in_front(const TileColors& front, std::size_t count, TileColors& colors);

/// Adds the largest values as white light over the colours. A colour is attenuated by 1 minus the
/// grey value that the projection has on its own.
void composite_mip(const LayerShading& shading, LayerWork& work, const ReceivedLight& received, WorkerCounts& counts,
                   TileColors& colors);

/// Writes the colours of a tile's traced blocks. A pixel of a lattice with a spacing also fills its
/// neighbours to the right and below, up to the next lattice pixel.
void write_colors(const PixelLattice& lattice, const Tile& tile, const TileColors& colors, Framebuffer& out,
                  Machine machine = chosen_machine());

/// Writes the framebuffer's channels for a tile's hits.
/// @param normals  of the hits: towards the eye, world axes; read only if the framebuffer has a
///                 normal channel
void write_channels(const PixelLattice& lattice, const Tile& tile, const HitBatch& hits, const Vec3* normals,
                    Framebuffer& out);

/// Writes the pixels of the untraced blocks: the values of a ray that hits nothing and costs
/// nothing.
void write_background(const Vec3& background, const PixelLattice& lattice, const Tile& tile, Framebuffer& out);

}  // namespace rhoray::render
