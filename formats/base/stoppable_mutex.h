#pragma once

#include <condition_variable>
#include <mutex>
#include <stop_token>

#include "formats/base/stopping.h"

namespace rhoray {

/// A mutex for long work: a stop request ends the waiting for it. Any thread may lock it.
class StoppableMutex {
 public:
  /// Locks at once if nobody holds the mutex, also after a stop request. Throws
  /// ErrorCode::interrupted if a stop is requested while another caller holds it.
  void lock(const std::stop_token& stop) {
    std::unique_lock lock(guard_);
    // A waiter that is woken and stopped at once takes the mutex, so that its wake-up is not lost.
    if (is_held_ && !released_.wait(lock, stop, [&] { return !is_held_; })) throw_interrupted();
    is_held_ = true;
  }
  void unlock() {
    {
      const std::lock_guard lock(guard_);
      is_held_ = false;
    }
    released_.notify_one();
  }

 private:
  std::mutex guard_;
  std::condition_variable_any released_;
  bool is_held_ = false;
};

/// Holds a StoppableMutex while it lives.
class StoppableLock {
 public:
  StoppableLock(StoppableMutex& mutex, const std::stop_token& stop) : mutex_(mutex) { mutex_.lock(stop); }
  ~StoppableLock() { mutex_.unlock(); }
  StoppableLock(const StoppableLock&) = delete;
  StoppableLock& operator=(const StoppableLock&) = delete;

 private:
  StoppableMutex& mutex_;
};

}  // namespace rhoray
