#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "render/frame/tile_threads.h"
#include "render/frame/worker.h"
#include "render/render.h"
#include "render/shadow/occluder_cache.h"

namespace rhoray::render {

/// The threads and their memory. Each thread allocates its memory when it first works.
class RenderContext::Implementation {
 public:
  explicit Implementation(Arena arena) : arena_(arena) {}

  /// @param threads  as FrameOptions::threads
  void begin_frame(unsigned threads, const WorkerNeeds& needs);
  const TileThreads& threads() const { return *threads_; }
  const TileThreads& threads(unsigned threads);  ///< as FrameOptions::threads
  Worker& worker(std::size_t index);
  /// Workers that have worked in this frame.
  std::vector<const Worker*> workers() const;
  /// Only for the thread that begins frames.
  wide::OccluderCache& occluders() { return occluders_; }

 private:
  struct Place {
    std::unique_ptr<Worker> worker;
    bool works = false;  ///< in this frame
  };
  Arena arena_;
  std::optional<TileThreads> threads_;
  std::vector<Place> places_;
  WorkerNeeds needs_;
  wide::OccluderCache occluders_;
};

}  // namespace rhoray::render
