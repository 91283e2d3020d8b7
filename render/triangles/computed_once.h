#pragma once

#include <memory>
#include <mutex>
#include <stop_token>

namespace rhoray::render {

/// A result that belongs to one mesh or surface. The first call computes it. Any thread may call.
template <class Computed>
class ComputedOnce {
 public:
  /// @param threads  0 = all cores
  /// @param stop     ends it (ErrorCode::interrupted); then nothing is kept
  template <class View>
  std::shared_ptr<const Computed> of(const View& view, unsigned threads, const std::stop_token& stop = {}) {
    const std::lock_guard lock(mutex_);
    if (!computed_) computed_ = std::make_shared<const Computed>(view, threads, stop);
    return computed_;
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const Computed> computed_;
};

}  // namespace rhoray::render
