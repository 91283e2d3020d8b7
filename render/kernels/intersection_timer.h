#pragma once

#include "render/kernels/kernels.h"
#include "render/march/ticks.h"

namespace rhoray::render {

/// Adds the time of its life to the counters; nothing at all in kernels that are not timed.
template <bool timed>
class IntersectionTimer {
 public:
  RHORAY_INLINE explicit IntersectionTimer(KernelCounters& counters)
      : counters_(counters), start_(timed ? ticks_now() : 0) {}
  RHORAY_INLINE ~IntersectionTimer() {
    if constexpr (timed) counters_.intersection_ticks += ticks_now() - start_;
  }
  IntersectionTimer(const IntersectionTimer&) = delete;
  IntersectionTimer& operator=(const IntersectionTimer&) = delete;

 private:
  KernelCounters& counters_;
  std::uint64_t start_;
};

}  // namespace rhoray::render
