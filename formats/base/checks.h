#pragma once

#include <cstdio>
#include <cstdlib>

/// Checks an internal invariant: prints the expression and aborts. Never use it for input errors
/// (use formats/base/error.h).
#define RHORAY_CHECK(condition)                                                                   \
  do {                                                                                            \
    if (!(condition)) [[unlikely]] {                                                              \
      std::fprintf(stderr, "%s:%d: internal check failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                               \
    }                                                                                             \
  } while (false)

/// Like RHORAY_CHECK, for hot loops: active only in builds with RHORAY_DCHECKS, such as the
/// sanitizer builds.
#ifndef RHORAY_DCHECKS
#define RHORAY_DCHECK(condition) ((void)0)
#else
#define RHORAY_DCHECK(condition) RHORAY_CHECK(condition)
#endif

/// For shared helpers of the kernels. Always inlined, so that a weak copy compiled for one machine
/// never runs on another.
#define RHORAY_INLINE [[gnu::always_inline]] inline
