#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace rhoray::render {

/// Threads that process tiles. They are kept from frame to frame, because starting them takes as
/// long as a small frame.
class TileThreads {
 public:
  explicit TileThreads(unsigned threads);  ///< 0: all cores
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
  struct Arena;
  unsigned threads_;
  std::unique_ptr<Arena> arena_;
};

}  // namespace rhoray::render
