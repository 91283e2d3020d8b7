#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/query/batch.h"

/// Order in which the pixels of a picture are traced: tile by tile, and block by block within a
/// tile.
namespace rhoray::render {

constexpr int tile_edge = 32;  ///< about 1,000 rays per batch; about 1,000 tiles per million pixels
constexpr int block_edge = 8;  ///< a full block is one group of a batch
constexpr int tile_blocks = tile_edge / block_edge;  ///< across and down
constexpr std::size_t tile_capacity = std::size_t{tile_edge} * tile_edge;
static_assert(std::size_t{block_edge} * block_edge == RayBatch::group_size);

/// Half-open ranges of columns and rows, and the blocks in them that are traced.
struct Tile {
  static constexpr std::uint16_t all_blocks = 0xffff;

  int x_begin, x_end, y_begin, y_end;
  /// Bit column + tile_blocks * row; bits beyond the tile are ignored.
  std::uint16_t blocks = all_blocks;

  bool has_block(int column, int row) const { return (blocks >> (column + tile_blocks * row) & 1) != 0; }

  /// Pixels, traced or not.
  std::size_t count() const {
    return static_cast<std::size_t>(x_end - x_begin) * static_cast<std::size_t>(y_end - y_begin);
  }
};

struct TilePlace {
  int column, row;
};

/// Position on the Hilbert curve through size x size positions after `steps` steps; size is a power
/// of two.
constexpr TilePlace hilbert_place(std::size_t size, std::size_t steps) {
  std::size_t x = 0, y = 0;
  for (std::size_t side = 1; side < size; side *= 2, steps /= 4) {
    const std::size_t right = steps / 2 & 1, down = (steps ^ right) & 1;
    if (down == 0) {
      if (right == 1) x = side - 1 - x, y = side - 1 - y;
      std::swap(x, y);
    }
    x += side * right, y += side * down;
  }
  return {static_cast<int>(x), static_cast<int>(y)};
}

/// Returns the tiles of a picture in an order where consecutive tiles are adjacent.
std::vector<Tile> tiles_in_order(int width, int height);

/// Up to block_edge pixels side by side; `first` is the index of the first one in the tile's batch.
struct Run {
  std::size_t first;
  int x, y;
  int count;
};

/// Calls act(run) for all pixels of a tile's traced blocks. Full blocks come first, each one a
/// group of the batch. Then come the pixels of blocks that the picture's border cuts.
template <class Act>
RHORAY_INLINE void for_each_run(const Tile& tile, const Act& act) {
  constexpr auto block_order = [] {
    std::array<TilePlace, std::size_t{tile_blocks} * tile_blocks> order{};
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = hilbert_place(tile_blocks, i);
    return order;
  }();
  std::size_t first = 0;
  for (const bool full : {true, false})
    for (const TilePlace& place : block_order) {
      const int x = tile.x_begin + place.column * block_edge, y_begin = tile.y_begin + place.row * block_edge;
      const int count = std::min(block_edge, tile.x_end - x), y_end = std::min(y_begin + block_edge, tile.y_end);
      if (count <= 0 || (count == block_edge && y_end - y_begin == block_edge) != full) continue;
      if (!tile.has_block(place.column, place.row)) continue;
      for (int y = y_begin; y < y_end; ++y) {
        act(Run{first, x, y, count});
        first += static_cast<std::size_t>(count);
      }
    }
}

/// Calls act(x, y, count) for the untraced pixels of a tile, for as many side by side as possible.
template <class Act>
void for_each_untraced_run(const Tile& tile, const Act& act) {
  for (int y = tile.y_begin; y < tile.y_end; ++y) {
    const int row = (y - tile.y_begin) / block_edge;
    for (int column = 0; column < tile_blocks;) {
      const int first = column;
      while (column < tile_blocks && !tile.has_block(column, row)) ++column;
      const int x = tile.x_begin + first * block_edge, x_end = std::min(tile.x_begin + column * block_edge, tile.x_end);
      if (x < x_end) act(x, y, x_end - x);
      ++column;
    }
  }
}

}  // namespace rhoray::render
