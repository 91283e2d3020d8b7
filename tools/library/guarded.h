#pragma once

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "rhoray/error.h"

namespace rhoray::v0_1::inside {

/// Calls act() in the default floating-point environment. Errors of the rooms become errors of the
/// library. Every public function that can fail calls the rooms through this one.
template <class Act>
decltype(auto) guarded(Act&& act) {
  const DefaultFloatingPoint default_floating_point;
  try {
    return act();
  } catch (const rhoray::Error& error) {
    throw v0_1::Error(static_cast<v0_1::ErrorCode>(error.code()), error.what(), error.hint());
  }
}

/// Refuses a call.
template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw v0_1::Error(v0_1::ErrorCode::usage, concat(parts...));
}

}  // namespace rhoray::v0_1::inside
