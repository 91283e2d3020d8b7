#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/progress.h"
#include "formats/base/text.h"
#include "rhoray/error.h"
#include "rhoray/progress.h"

namespace rhoray::v0_1::inside {

/// Carries what a callback threw through the rooms.
struct ThrownByCallback {
  std::exception_ptr exception;
};

/// Calls a callback of the caller. `guarded` throws its exceptions again as they were.
template <class Callback, class... Arguments>
decltype(auto) call_back(const Callback& callback, Arguments&&... arguments) {
  try {
    return callback(std::forward<Arguments>(arguments)...);
  } catch (...) {
    throw ThrownByCallback{std::current_exception()};
  }
}

/// The caller's watch, for the rooms. It refers to `watch`.
inline rhoray::Watch inside_of(const Watch& watch) {
  rhoray::Watch inside(watch.stop);
  if (watch.progress)
    inside.progress = [&watch](std::string_view phase, std::uint64_t done, std::uint64_t total) {
      call_back(watch.progress, phase, done, total);
    };
  return inside;
}

/// A hint of the rooms; none if it names an option of the program. A whole command in backquotes may
/// have options.
inline std::string for_library(const std::string& hint) {
  bool is_quoted = false;
  for (std::size_t i = 0; i < hint.size(); ++i) {
    if (hint[i] == '`') is_quoted = !is_quoted;
    if (!is_quoted && hint.compare(i, 2, "--") == 0) return {};
  }
  return hint;
}

/// Calls act() in the default floating-point environment. Errors of the rooms, of the standard
/// library and of the system become errors of this library; a size above all memory becomes
/// std::bad_alloc. Every public function that can fail calls the rooms through this one.
template <class Act>
decltype(auto) guarded(Act&& act) {
  const DefaultFloatingPoint default_floating_point;
  try {
    return act();
  } catch (const ThrownByCallback& thrown) {
    std::rethrow_exception(thrown.exception);
  } catch (const rhoray::Error& error) {
    throw v0_1::Error(static_cast<v0_1::ErrorCode>(error.code()), error.what(), for_library(error.hint()));
  } catch (const std::filesystem::filesystem_error& error) {
    throw v0_1::Error(v0_1::ErrorCode::unreadable, concat(error.path1().string(), ": ", error.code().message()));
  } catch (const std::system_error& error) {
    throw v0_1::Error(v0_1::ErrorCode::resource, error.what());
  } catch (const std::length_error&) {
    throw std::bad_alloc();
  }
}

/// Refuses a call.
template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw v0_1::Error(v0_1::ErrorCode::usage, concat(parts...));
}

/// Refuses a number that is none of an enumeration's values.
/// @param last  the enumeration's last value
template <class Enumeration>
void require_enumerator(std::string_view name, Enumeration value, Enumeration last) {
  const auto number = static_cast<int>(value);
  if (number < 0 || number > static_cast<int>(last))
    refuse(name, ": found ", number, "; expected a number from 0 to ", static_cast<int>(last));
}

}  // namespace rhoray::v0_1::inside
