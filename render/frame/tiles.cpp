#include "render/frame/tiles.h"

#include <bit>

namespace rhoray::render {

std::vector<Tile> tiles_in_order(int width, int height) {
  const int across = (width - 1) / tile_edge + 1, down = (height - 1) / tile_edge + 1;
  // Squares side by side along the longer edge. Each is filled by a curve that ends next to the
  // start of the next one.
  const auto shorter = static_cast<std::size_t>(std::min(across, down));
  const std::size_t size = std::bit_ceil(shorter), longer = static_cast<std::size_t>(std::max(across, down));
  std::vector<Tile> tiles;
  tiles.reserve(shorter * longer);
  for (std::size_t square = 0; square * size < longer; ++square)
    for (std::size_t step = 0; step < size * size; ++step) {
      TilePlace place = hilbert_place(size, step);
      place.column += static_cast<int>(square * size);
      if (down > across) std::swap(place.column, place.row);
      if (place.column >= across || place.row >= down) continue;
      const int x = place.column * tile_edge, y = place.row * tile_edge;
      tiles.push_back({x, std::min(width - x, tile_edge) + x, y, std::min(height - y, tile_edge) + y});
    }
  return tiles;
}

}  // namespace rhoray::render
