// Tests RHORAY_DCHECK in builds with checks of hot loops, such as the sanitizer presets.
#ifndef RHORAY_DCHECKS
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#error "builds with sanitizers define RHORAY_DCHECKS (CMakeLists.txt)"
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#error "builds with sanitizers define RHORAY_DCHECKS (CMakeLists.txt)"
#endif
#endif
#define RHORAY_DCHECKS  // always defined here, so that the test also runs in builds without it
#endif
#include "formats/base/checks.h"

#include <gtest/gtest.h>

namespace rhoray {
namespace {

TEST(ChecksDeathTest, of_hot_loops_stop_and_print_the_expression_also_with_ndebug) {
  const int count = 3;
  RHORAY_DCHECK(count < 4);
  EXPECT_DEATH(RHORAY_DCHECK(count < 3), "checks_test.cpp:[0-9]+: internal check failed: count < 3");
}

}  // namespace
}  // namespace rhoray
