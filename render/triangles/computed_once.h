#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>

#include "formats/base/stoppable_mutex.h"

namespace rhoray::render {

/// A result that belongs to one mesh or surface. The first call computes it, and so does the first
/// one after `clear`. Any thread may call.
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

  std::size_t size_bytes() {
    const StoppableLock lock(mutex_, {});
    return computed_ ? computed_->size_bytes() : 0;
  }
  void clear() {
    const StoppableLock lock(mutex_, {});
    computed_.reset();
  }

 private:
  StoppableMutex mutex_;
  std::shared_ptr<const Computed> computed_;
};

}  // namespace rhoray::render
