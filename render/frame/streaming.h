#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "render/query/machine.h"

/// Stores that bypass the caches. A picture is larger than the caches and not read before it is
/// complete. So its old contents need not be loaded from memory to be overwritten. Only whole cache
/// lines are streamed; the rest is stored normally.
namespace rhoray::render {

inline constexpr std::size_t line_floats = 64 / sizeof(float);

RHORAY_INLINE bool begins_line(const float* place) {
  return reinterpret_cast<std::uintptr_t>(place) % 64 == 0;
}

/// Copies whole cache lines; both pointers must be aligned to a cache line.
template <std::size_t lines>
RHORAY_INLINE void stream_lines(const float* from, float* to) {
#if defined(__SSE__)
  using Four [[gnu::vector_size(16), gnu::may_alias]] = float;
  for (std::size_t i = 0; i < lines * line_floats; i += 4) {
    const Four four = *reinterpret_cast<const Four*>(from + i);
#if defined(__clang__)
    __builtin_nontemporal_store(four, reinterpret_cast<Four*>(to + i));
#else
    __builtin_ia32_movntps(to + i, four);
#endif
  }
#else
  std::copy_n(from, lines * line_floats, to);
#endif
}

/// Must be called after streaming, before another thread learns that the data are complete.
inline void end_streaming() {
#if defined(__SSE__)
  __builtin_ia32_sfence();
#endif
}

}  // namespace rhoray::render
