#pragma once

#include <cfenv>

namespace rhoray {

/// Sets the default floating-point environment for the calling thread while the object lives:
/// rounding to nearest, denormal numbers kept (neither FTZ nor DAZ on x86), traps off. The
/// destructor restores the caller's whole environment, including its exception flags. So the caller
/// sees no flag that operations in between have raised.
///
/// Error bounds, exact arithmetic and the comparison of stored ranges are proven for this
/// environment. A host program may run in another one, and a library built with -ffast-math may
/// have changed it. So every public function that computes has such a guard. Every task on a pool
/// thread has one too, because pool threads have the environment of whoever started them. A guard
/// costs about a hundred nanoseconds, so guards surround tiles and ranges, never single rays.
///
/// Constructor and destructor are not inline. The compiler assumes the default environment and may
/// move arithmetic across code that it can see. It cannot move loads from memory across these
/// calls.
class DefaultFloatingPoint {
 public:
  DefaultFloatingPoint();
  ~DefaultFloatingPoint();
  DefaultFloatingPoint(const DefaultFloatingPoint&) = delete;
  DefaultFloatingPoint& operator=(const DefaultFloatingPoint&) = delete;

 private:
  std::fenv_t callers_;
};

}  // namespace rhoray
