#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray {

// For the shared library, instead of failed_check.cpp: a library ends no program.
void fail_check(const char* file, int line, const char* condition) {
  throw Error(ErrorCode::internal, concat(file, ":", line, ": internal check failed: ", condition));
}

}  // namespace rhoray
