#pragma once

#include <cstddef>
#include <functional>

namespace rhoray::render {

/// Calls act(tile, worker) once for every tile in [0, count), on `threads` threads (0 = all cores); `worker` is below
/// worker_count(threads) and never used by two calls at a time. An exception thrown by act ends the work and is passed
/// on.
void for_each_tile(std::size_t count, unsigned threads,
                   const std::function<void(std::size_t tile, std::size_t worker)>& act);

std::size_t worker_count(unsigned threads);

}  // namespace rhoray::render
