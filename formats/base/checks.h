#pragma once

#include <cstdio>
#include <cstdlib>

/// Our own broken promise: prints the expression and stops. Never for input (that is
/// formats/base/error.h).
#define RHORAY_CHECK(condition)                                                                   \
  do {                                                                                            \
    if (!(condition)) [[unlikely]] {                                                              \
      std::fprintf(stderr, "%s:%d: internal check failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                               \
    }                                                                                             \
  } while (false)

/// As RHORAY_CHECK, where the check would cost a hot loop: only in builds with RHORAY_DCHECKS, as
/// sanitizers have it.
#ifndef RHORAY_DCHECKS
#define RHORAY_DCHECK(condition) ((void)0)
#else
#define RHORAY_DCHECK(condition) RHORAY_CHECK(condition)
#endif

/// Shared helpers of the kernels: inlined always, so that no weak copy compiled for one machine
/// runs on another.
#define RHORAY_INLINE [[gnu::always_inline]] inline
