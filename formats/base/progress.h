#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

namespace rhoray {

/// Called now and then during long work, from one thread at a time, with the current phase and how
/// much of it is done. `total` is 0 where it is not known. A phase may end with the unit that is
/// counted, in brackets: "writing (bytes)". The callback may throw to stop the work; no partial
/// result is left behind.
using Progress = std::function<void(std::string_view phase, std::uint64_t done, std::uint64_t total)>;

/// One phase of work done by many threads at once. Adds up what they report and passes it on, one
/// call at a time.
class ProgressMeter {
 public:
  ProgressMeter(const Progress& progress, std::string phase, std::uint64_t total)
      : progress_(progress), phase_(std::move(phase)), total_(total) {
    if (progress_) progress_(phase_, 0, total_);
  }

  void add(std::uint64_t done) {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    done_ += done;
    progress_(phase_, done_, total_);
  }

 private:
  const Progress& progress_;
  std::string phase_;
  std::uint64_t total_;
  std::uint64_t done_ = 0;
  std::mutex mutex_;
};

/// How a caller watches long work: ends it (ErrorCode::interrupted) and hears how far it has come.
/// A stop token alone converts to it.
struct Watch {
  Watch(std::stop_token requests = {}, Progress report = {}) : stop(std::move(requests)), progress(std::move(report)) {}

  std::stop_token stop;
  Progress progress;
};

}  // namespace rhoray
