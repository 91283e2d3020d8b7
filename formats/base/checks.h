#pragma once

namespace rhoray {

/// Ends a program whose state is wrong: prints the expression and aborts. In the shared library it
/// throws ErrorCode::internal instead (failed_check_library.cpp).
[[noreturn, gnu::cold]] void fail_check(const char* file, int line, const char* condition);

}  // namespace rhoray

/// Checks an internal invariant. Never use it for input errors (use formats/base/error.h).
#define RHORAY_CHECK(condition)                             \
  do {                                                      \
    if (!(condition)) [[unlikely]]                          \
      ::rhoray::fail_check(__FILE__, __LINE__, #condition); \
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
