#pragma once

#include <cstdint>
#include <cstdlib>

namespace rhoray::tests {

/// How many cases a test runs: what an environment variable says (tests/nightly), else `plain`; a tenth of that under a
/// sanitizer, which takes ten times as long.
inline std::uint64_t asked_count(const char* variable, std::uint64_t plain) {
  if (const char* const asked = std::getenv(variable)) return static_cast<std::uint64_t>(std::strtod(asked, nullptr));
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return plain / 10;
#else
  return plain;
#endif
}

}  // namespace rhoray::tests
