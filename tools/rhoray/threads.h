#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace rhoray::tools {

/// While it lives, oneTBB works on at most so many threads; 0 leaves it all cores.
class ThreadLimit {
 public:
  explicit ThreadLimit(unsigned threads)
      : control_(tbb::global_control::max_allowed_parallelism,
                 threads == 0 ? static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()) : threads) {}

 private:
  tbb::global_control control_;
};

}  // namespace rhoray::tools
