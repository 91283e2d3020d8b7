#include "render/frame/for_each_tile.h"

#include <algorithm>
#include <thread>

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
#endif

namespace rhoray::render {

std::size_t worker_count(unsigned threads) {
  return threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

#ifdef RHORAY_STD_THREADS

void for_each_tile(std::size_t count, unsigned threads, const std::function<void(std::size_t, std::size_t)>& act) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr first_failure;
  std::mutex failure_mutex;
  {
    std::vector<std::jthread> workers;
    for (std::size_t worker = 0; worker < worker_count(threads); ++worker)
      workers.emplace_back([&, worker] {
        try {
          for (std::size_t tile; (tile = next++) < count;) act(tile, worker);
        } catch (...) {
          const std::lock_guard lock(failure_mutex);
          if (!first_failure) first_failure = std::current_exception();
          next = count;
        }
      });
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

#else

void for_each_tile(std::size_t count, unsigned threads, const std::function<void(std::size_t, std::size_t)>& act) {
  // oneTBB gives an arena no more threads than there are cores unless it is told so.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, worker_count(threads));
  tbb::task_arena arena(static_cast<int>(worker_count(threads)));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& tiles) {
          const auto worker = static_cast<std::size_t>(tbb::this_task_arena::current_thread_index());
          for (std::size_t tile = tiles.begin(); tile != tiles.end(); ++tile) act(tile, worker);
        },
        tbb::simple_partitioner());
  });
}

#endif

}  // namespace rhoray::render
