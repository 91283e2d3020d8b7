#include "render/frame/tile_threads.h"

#include <algorithm>
#include <thread>

#include "formats/base/floating_point.h"

#ifdef RHORAY_STD_THREADS
#include <atomic>
#include <exception>
#include <mutex>
#include <vector>
#else
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <optional>
#endif

namespace rhoray::render {

std::size_t TileThreads::worker_count() const {
#ifndef RHORAY_STD_THREADS
  if (!arena_) return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
#endif
  return threads_ > 0 ? threads_ : std::max(1u, std::thread::hardware_concurrency());
}

#ifdef RHORAY_STD_THREADS

struct TileThreads::OwnArena {};

TileThreads::TileThreads(unsigned threads, Arena) : threads_(threads) {}
TileThreads::~TileThreads() = default;

void TileThreads::for_each_tile(std::size_t count, const std::function<void(std::size_t, std::size_t)>& act) const {
  std::atomic<std::size_t> next{0};
  std::exception_ptr first_failure;
  std::mutex failure_mutex;
  const auto work = [&](std::size_t worker) {
    const DefaultFloatingPoint default_floating_point;
    try {
      for (std::size_t tile; (tile = next++) < count;) act(tile, worker);
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (!first_failure) first_failure = std::current_exception();
      next = count;
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t worker = 1; worker < worker_count(); ++worker) others.emplace_back(work, worker);
    work(0);
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

#else

struct TileThreads::OwnArena {
  tbb::task_arena arena;
};

TileThreads::TileThreads(unsigned threads, Arena arena) : threads_(threads) {
  if (arena == Arena::callers) return;
  const unsigned count = threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
  arena_ = std::make_unique<OwnArena>(OwnArena{tbb::task_arena(static_cast<int>(count))});
}
TileThreads::~TileThreads() = default;

void TileThreads::for_each_tile(std::size_t count, const std::function<void(std::size_t, std::size_t)>& act) const {
  // A group of its own: oneTBB leaves out what belongs to a cancelled group of the caller's.
  tbb::task_group_context group(tbb::task_group_context::isolated);
  const auto work = [&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& tiles) {
          // Pool threads, and the settings that oneTBB applies to its tasks, come from whoever used
          // the pool first.
          const DefaultFloatingPoint default_floating_point;
          const auto worker = static_cast<std::size_t>(tbb::this_task_arena::current_thread_index());
          for (std::size_t tile = tiles.begin(); tile != tiles.end(); ++tile) act(tile, worker);
        },
        tbb::simple_partitioner(), group);
  };
  // Isolated: a thread that waits here takes no task of the caller, which might wait for this one.
  if (!arena_) return tbb::this_task_arena::isolate(work);
  // oneTBB limits an arena to the number of cores unless it is told otherwise.
  std::optional<tbb::global_control> allowed;
  if (worker_count() > std::thread::hardware_concurrency())
    allowed.emplace(tbb::global_control::max_allowed_parallelism, worker_count());
  arena_->arena.execute(work);
}

#endif

}  // namespace rhoray::render
