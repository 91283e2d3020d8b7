#pragma once

#include <cfenv>

namespace rhoray {

/// Default floating-point environment for the calling thread, as long as the object lives: rounding
/// to nearest, denormal numbers kept (neither FTZ nor DAZ on x86), traps off. The destructor
/// restores the caller's environment as a whole, its exception flags included: operations in
/// between raise no flag that the caller sees.
///
/// Error bounds, exact arithmetic and the comparison of stored ranges are proven for this
/// environment. A host program may run in another one, or a library built with -ffast-math may have
/// set it. So every public function that computes has such a guard, and every task that runs on a
/// thread of a pool: threads of a pool have the environment of whoever started them. It costs about
/// a hundred nanoseconds, so it stands around tiles and ranges, never around single rays.
///
/// Constructor and destructor are not inline: the compiler, which takes the environment for the
/// default one, may move arithmetic across what it can look into, but no loads from memory across
/// these calls.
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
