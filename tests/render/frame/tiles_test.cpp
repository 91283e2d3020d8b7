#include "render/frame/tiles.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <vector>

namespace rhoray::tests {
namespace {

using render::Tile;

TEST(Tiles, cover_every_pixel_once_and_follow_each_other_side_by_side) {
  for (const auto& [width, height] : {std::pair(1, 1), {33, 65}, {1024, 1024}, {1920, 1080}, {7, 3000}, {3000, 31}}) {
    std::vector<int> covered(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    int jumps = 0;
    const std::vector<Tile> tiles = render::tiles_in_order(width, height);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const Tile& tile = tiles[i];
      EXPECT_LE(tile.count(), render::tile_capacity);
      for (int y = tile.y_begin; y < tile.y_end; ++y)
        for (int x = tile.x_begin; x < tile.x_end; ++x) ++covered[static_cast<std::size_t>(y * width + x)];
      if (i > 0)
        jumps += std::abs(tile.x_begin - tiles[i - 1].x_begin) + std::abs(tile.y_begin - tiles[i - 1].y_begin) !=
                 render::tile_edge;
    }
    EXPECT_EQ(std::set<int>(covered.begin(), covered.end()), std::set<int>{1}) << width << " x " << height;
    EXPECT_LE(jumps, width == 1920 ? 60 : 0) << width << " x " << height << ": only where the curve leaves the picture";
  }
}

TEST(ForEachRun, makes_every_full_block_a_group) {
  for (const Tile tile : {Tile{64, 96, 32, 64}, Tile{64, 93, 32, 53}, Tile{0, 5, 0, 32}, Tile{32, 64, 0, 3}}) {
    std::vector<render::Run> runs;
    for_each_run(tile, [&](const render::Run& run) { runs.push_back(run); });
    std::set<std::pair<int, int>> pixels;
    std::size_t next = 0;
    const int full_blocks = (tile.x_end - tile.x_begin) / 8 * ((tile.y_end - tile.y_begin) / 8);
    for (const render::Run& run : runs) {
      EXPECT_EQ(run.first, next);
      next += static_cast<std::size_t>(run.count);
      for (int i = 0; i < run.count; ++i) pixels.insert({run.x + i, run.y});
      EXPECT_TRUE(run.x >= tile.x_begin && run.x + run.count <= tile.x_end && run.y >= tile.y_begin &&
                  run.y < tile.y_end);
      if (run.first < 64U * static_cast<std::size_t>(full_blocks)) {
        const render::Run& of_group = runs[run.first / 64 * 8];  // its first
        EXPECT_EQ(run.x, of_group.x);
        EXPECT_EQ(run.y, of_group.y + static_cast<int>(run.first % 64 / 8));
      }
    }
    EXPECT_EQ(next, tile.count());
    EXPECT_EQ(pixels.size(), tile.count());
  }
}

}  // namespace
}  // namespace rhoray::tests
