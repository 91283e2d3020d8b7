#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "render/render.h"

namespace rhoray::render {

/// Threads that process tiles. They are kept from frame to frame, because starting them takes as
/// long as a small frame.
class TileThreads {
 public:
  /// @param threads  0: all cores; ignored with the caller's arena, which must be the same at each
  ///   later call
  explicit TileThreads(unsigned threads, Arena arena = Arena::own);
  ~TileThreads();

  unsigned asked_for() const { return threads_; }
  std::size_t worker_count() const;

  /// Calls act(tile, worker) once for every tile in [0, count). Neighbouring tiles are mostly
  /// processed one after another on one thread. `worker` is below worker_count(), and no two
  /// simultaneous calls have the same one. An exception thrown by act ends the work and is
  /// rethrown. Each call computes in the default floating-point environment
  /// (formats/base/floating_point.h).
  void for_each_tile(std::size_t count, const std::function<void(std::size_t tile, std::size_t worker)>& act) const;

 private:
  struct OwnArena;
  unsigned threads_;
  std::unique_ptr<OwnArena> arena_;  ///< null: the caller's
};

}  // namespace rhoray::render
