#include "tests/fuzz/harness.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "formats/base/checks.h"
#include "formats/base/text.h"

namespace rhoray::tests {

void check_refusal(const Error& error) {
  RHORAY_CHECK(error.code() != ErrorCode::internal && error.code() != ErrorCode::interrupted);
  const std::string fact = error.what();
  constexpr std::size_t longest_fact = 4000;
  RHORAY_CHECK(!fact.empty() && fact.size() <= longest_fact);
  RHORAY_CHECK(std::count(fact.begin(), fact.end(), '\n') == 0);
  static const bool says = std::getenv("RHORAY_FUZZ_SAY") != nullptr;
  if (says) std::fprintf(stderr, "%s\n", fact.c_str());
}

InputFile::InputFile() : descriptor_(::memfd_create("rhoray-fuzz", MFD_CLOEXEC)) {
  RHORAY_CHECK(descriptor_ >= 0);
  path_ = concat("/proc/self/fd/", descriptor_);
}

InputFile::~InputFile() {
  ::close(descriptor_);
}

void InputFile::put(const std::uint8_t* data, std::size_t size) {
  RHORAY_CHECK(::ftruncate(descriptor_, 0) == 0);
  RHORAY_CHECK(::pwrite(descriptor_, data, size, 0) == static_cast<ssize_t>(size));
}

}  // namespace rhoray::tests
