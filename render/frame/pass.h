#pragma once

#include <cstddef>
#include <vector>

#include "render/frame/frame.h"

namespace rhoray::render {

/// Pixels that are traced together, before the next update of the picture: those of a few lattices.
/// Rays are made and traced only in blocks of pixels that may see a layer's boxes. All other blocks
/// are background.
class Pass {
 public:
  void add(const Frame& frame, const PixelLattice& lattice);

  std::size_t tile_count() const { return tiles_.size(); }
  void trace_tile(const Frame& frame, std::size_t index, Worker& worker, Framebuffer& out) const;

 private:
  struct PassTile {
    std::size_t rays;
    Tile tile;
  };

  std::vector<LatticeRays> rays_;
  std::vector<PassTile> tiles_;
};

/// Shades a tile's hits into Worker::colors.
void shade_layers(const Frame& frame, Worker& worker);

}  // namespace rhoray::render
