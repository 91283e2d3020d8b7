#include "render/frame/for_each_tile.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace rhoray::tests {
namespace {

TEST(ForEachTile, calls_every_tile_once_with_a_worker_of_its_own) {
  for (const unsigned threads : {0U, 1U, 2U, 8U}) {
    std::vector<std::atomic<int>> calls(1000);
    std::vector<std::atomic<int>> busy(render::worker_count(threads));
    std::atomic<bool> shared{false};
    render::for_each_tile(calls.size(), threads, [&](std::size_t tile, std::size_t worker) {
      ASSERT_LT(worker, busy.size());
      if (busy[worker]++ != 0) shared = true;
      ++calls[tile];
      --busy[worker];
    });
    for (const auto& count : calls) EXPECT_EQ(count, 1);
    EXPECT_FALSE(shared) << "two calls used one worker at a time";
  }
  EXPECT_EQ(render::worker_count(3), 3U);
  EXPECT_GE(render::worker_count(0), 1U);
}

TEST(ForEachTile, does_nothing_for_no_tiles) {
  render::for_each_tile(0, 2, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(ForEachTile, passes_an_exception_on) {
  for (const unsigned threads : {1U, 4U})
    EXPECT_THROW(render::for_each_tile(100, threads,
                                       [](std::size_t tile, std::size_t) {
                                         if (tile == 37) throw std::runtime_error("tile 37");
                                       }),
                 std::runtime_error);
}

}  // namespace
}  // namespace rhoray::tests
