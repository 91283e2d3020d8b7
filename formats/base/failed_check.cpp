#include <cstdio>
#include <cstdlib>

#include "formats/base/checks.h"

namespace rhoray {

void fail_check(const char* file, int line, const char* condition) {
  std::fprintf(stderr, "%s:%d: internal check failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace rhoray
