#pragma once

#include "render/query/kernels.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

/// Adds the time between construction and destruction to the counters if the query asks for it.
class IntersectionTimer {
 public:
  RHORAY_INLINE IntersectionTimer(const RayQuery& query, KernelCounters& counters)
      : counters_(query.time_phases ? &counters : nullptr), start_(counters_ != nullptr ? ticks_now() : 0) {}
  RHORAY_INLINE ~IntersectionTimer() {
    if (counters_ != nullptr) counters_->intersection_ticks += ticks_now() - start_;
  }
  IntersectionTimer(const IntersectionTimer&) = delete;
  IntersectionTimer& operator=(const IntersectionTimer&) = delete;

 private:
  KernelCounters* counters_;
  std::uint64_t start_;
};

}  // namespace rhoray::render
