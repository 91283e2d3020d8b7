#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stop_token>

#include "formats/base/stopping.h"

namespace rhoray {

/// A mutex for long work: a stop request ends the waiting for it. Any thread may lock it. Unlike
/// std::mutex it must live until `unlock` has returned.
class StoppableMutex {
 public:
  /// Locks at once if nobody holds the mutex, also after a stop request. Throws
  /// ErrorCode::interrupted if a stop is requested while another caller holds it.
  void lock(const std::stop_token& stop) {
    if (take()) return;
    std::unique_lock lock(guard_);
    ++waiter_count_;
    // A waiter that is woken and stopped at once takes the mutex, so that its wake-up is not lost.
    const bool has_taken = released_.wait(lock, stop, [&] { return take(); });
    --waiter_count_;
    if (!has_taken) throw_interrupted();
  }
  void unlock() {
    is_held_ = false;
    // A waiter counts itself before it looks at is_held_. So it sees false there, or is seen here.
    if (waiter_count_ == 0) return;
    const std::lock_guard lock(guard_);
    released_.notify_one();
  }

 private:
  bool take() { return !is_held_.exchange(true); }

  std::mutex guard_;
  std::condition_variable_any released_;
  std::atomic<bool> is_held_ = false;
  std::atomic<int> waiter_count_ = 0;
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
