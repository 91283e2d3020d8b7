#pragma once

#include <cstdint>
#include <cstdlib>

#include "tests/support/sanitizers.h"

namespace rhoray::tests {

/// Returns how many cases a test runs: the value of an environment variable if set (tests/nightly),
/// otherwise `plain`. Under a sanitizer, which takes ten times as long, a tenth of `plain`.
inline std::uint64_t asked_count(const char* variable, std::uint64_t plain) {
  if (const char* const asked = std::getenv(variable)) return static_cast<std::uint64_t>(std::strtod(asked, nullptr));
  return sanitized ? plain / 10 : plain;
}

}  // namespace rhoray::tests
