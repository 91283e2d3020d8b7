#include "render/frame/tile_threads.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace rhoray::tests {
namespace {

TEST(TileThreads, call_every_tile_once_a_frame_with_a_worker_of_its_own) {
  for (const unsigned threads : {0U, 1U, 2U, 8U}) {
    const render::TileThreads tile_threads(threads);
    std::vector<std::atomic<int>> calls(1000);
    std::vector<std::atomic<int>> busy(tile_threads.worker_count());
    std::atomic<bool> shared{false};
    for (int frame = 1; frame <= 3; ++frame) {
      tile_threads.for_each_tile(calls.size(), [&](std::size_t tile, std::size_t worker) {
        ASSERT_LT(worker, busy.size());
        if (busy[worker]++ != 0) shared = true;
        ++calls[tile];
        --busy[worker];
      });
      for (const auto& count : calls) EXPECT_EQ(count, frame);
    }
    EXPECT_FALSE(shared) << "two calls used one worker at a time";
  }
  EXPECT_EQ(render::TileThreads(3).worker_count(), 3U);
  EXPECT_GE(render::TileThreads(0).worker_count(), 1U);
}

TEST(TileThreads, do_nothing_for_no_tiles) {
  render::TileThreads(2).for_each_tile(0, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(TileThreads, pass_an_exception_on) {
  for (const unsigned threads : {1U, 4U})
    EXPECT_THROW(render::TileThreads(threads).for_each_tile(100,
                                                            [](std::size_t tile, std::size_t) {
                                                              if (tile == 37) throw std::runtime_error("tile 37");
                                                            }),
                 std::runtime_error);
}

TEST(TileThreads, call_every_tile_in_a_cancelled_group_of_the_caller) {
  for (const render::Arena arena : {render::Arena::own, render::Arena::callers}) {
    const render::TileThreads tile_threads(2, arena);
    std::atomic<int> calls{0};
    tbb::task_group_context group;
    tbb::parallel_for(
        0, 1,
        [&](int) {
          group.cancel_group_execution();
          tile_threads.for_each_tile(1000, [&](std::size_t, std::size_t) { ++calls; });
        },
        group);
    EXPECT_EQ(calls, 1000);
  }
}

}  // namespace
}  // namespace rhoray::tests
