#pragma once

namespace rhoray::tests {

/// True in builds with the address or the thread sanitizer.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

/// Why a test that limits memory is skipped there.
inline constexpr const char* no_limits_of_memory =
    "sanitizers reserve terabytes, keep what was freed, and end the process where memory is refused";

}  // namespace rhoray::tests
