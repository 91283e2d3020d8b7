#include "rhoray/error.h"

#include <utility>

#include "rhoray/version.h"

namespace rhoray::v0_1 {

Error::Error(ErrorCode code, const std::string& fact, std::string hint)
    : std::runtime_error(fact), code_(code), hint_(std::move(hint)) {}
Error::Error(const Error&) = default;
Error& Error::operator=(const Error&) = default;
Error::~Error() = default;

const char* library_version() noexcept {
  return RHORAY_VERSION;
}

}  // namespace rhoray::v0_1
