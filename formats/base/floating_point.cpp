#include "formats/base/floating_point.h"

#include "formats/base/checks.h"

namespace rhoray {

// The default environment of the C library has FTZ and DAZ off;
// tests/formats/floating_point_test.cpp checks this.
DefaultFloatingPoint::DefaultFloatingPoint() {
  RHORAY_CHECK(std::fegetenv(&callers_) == 0);
  RHORAY_CHECK(std::fesetenv(FE_DFL_ENV) == 0);
}

DefaultFloatingPoint::~DefaultFloatingPoint() {
  std::fesetenv(&callers_);
}

}  // namespace rhoray
