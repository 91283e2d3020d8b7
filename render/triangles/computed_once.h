#pragma once

#include <memory>
#include <stop_token>

#include "formats/base/stoppable_mutex.h"

namespace rhoray::render {

/// A result that belongs to one mesh or surface. The first call computes it. Any thread may call.
template <class Computed>
class ComputedOnce {
 public:
  /// @param threads  0 = all cores
  /// @param stop     ends it and the waiting for another caller (ErrorCode::interrupted); what was
  ///   ended is not kept
  template <class View>
  std::shared_ptr<const Computed> of(const View& view, unsigned threads, const std::stop_token& stop = {}) {
    const StoppableLock lock(mutex_, stop);
    if (!computed_) computed_ = std::make_shared<const Computed>(view, threads, stop);
    return computed_;
  }

 private:
  StoppableMutex mutex_;
  std::shared_ptr<const Computed> computed_;
};

}  // namespace rhoray::render
