#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "render/kernels/machine.h"

/// Stores that pass the caches by. A picture is larger than they are and not read before it is whole, so what lies
/// there need not be brought from memory to be overwritten. Only whole cache lines are streamed; the rest is stored as
/// ever.
namespace rhoray::render {

inline constexpr std::size_t line_floats = 64 / sizeof(float);

RHORAY_INLINE bool begins_line(const float* place) {
  return reinterpret_cast<std::uintptr_t>(place) % 64 == 0;
}

/// Copies whole cache lines to where one begins.
template <std::size_t lines>
RHORAY_INLINE void stream_lines(const float* from, float* to) {
#if defined(__SSE__)
  for (std::size_t i = 0; i < lines * line_floats; i += 4) _mm_stream_ps(to + i, _mm_load_ps(from + i));
#else
  std::copy_n(from, lines * line_floats, to);
#endif
}

/// To be called after streaming, before another thread is told that it is done.
inline void end_streaming() {
#if defined(__SSE__)
  _mm_sfence();
#endif
}

}  // namespace rhoray::render
