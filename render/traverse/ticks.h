#pragma once

#include <chrono>
#include <cstdint>

#include "formats/base/checks.h"

namespace rhoray::render {

/// A counter that rises evenly and is cheap to read. Its unit is found by comparison with a clock
/// over the whole frame.
RHORAY_INLINE std::uint64_t ticks_now() {
#ifdef __x86_64__
  return __builtin_ia32_rdtsc();
#else
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace rhoray::render
