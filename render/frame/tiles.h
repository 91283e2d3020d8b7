#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/query/batch.h"

/// In which order the pixels of a picture are traced: tile by tile, in a tile block by block.
namespace rhoray::render {

constexpr int tile_edge = 32;  ///< a thousand rays are asked about at a time; a thousand tiles in a million pixels
constexpr int block_edge = 8;  ///< a full block is one group of a batch
constexpr int tile_blocks = tile_edge / block_edge;  ///< across and down
constexpr std::size_t tile_capacity = std::size_t{tile_edge} * tile_edge;
static_assert(std::size_t{block_edge} * block_edge == RayBatch::group_size);

/// Columns and rows from begin to before end, and which blocks of them have pixels that are traced.
struct Tile {
  static constexpr std::uint16_t all_blocks = 0xffff;

  int x_begin, x_end, y_begin, y_end;
  std::uint16_t blocks = all_blocks;  ///< bit column + tile_blocks * row; bits beyond the tile's edges do not count

  bool has_block(int column, int row) const { return (blocks >> (column + tile_blocks * row) & 1) != 0; }

  /// Pixels, traced or not.
  std::size_t count() const {
    return static_cast<std::size_t>(x_end - x_begin) * static_cast<std::size_t>(y_end - y_begin);
  }
};

struct TilePlace {
  int column, row;
};

/// The place that Hilbert's curve through size x size places, a power of two, reaches after so many steps.
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

/// The tiles of a picture, in an order in which those that follow each other lie side by side.
std::vector<Tile> tiles_in_order(int width, int height);

/// Up to block_edge pixels side by side, and where they stand in the tile's batch.
struct Run {
  std::size_t first;
  int x, y;
  int count;
};

/// Calls act(run) for all pixels of a tile's traced blocks. Full blocks come first, each a group of the batch; the
/// pixels of the blocks that the picture's edge cuts follow.
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

/// Calls act(x, y, count) for the pixels of a tile's blocks that are not traced, as many at a time as lie side by side.
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
