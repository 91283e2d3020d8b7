#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <string_view>
#include <utility>

#include "rhoray/export.h"

namespace rhoray::RHORAY_ABI {

/// Called during a long call. `phase` says what is being done, with the unit that is counted in
/// brackets: "tracing (tiles)". `done` of `total` units are done; a total of 0 is not known.
///
/// Calls come one at a time, from any thread, and `done` never decreases within a phase. The
/// function should return soon, and must not call this library. If it throws, the long call ends
/// and throws the same exception.
using Progress = std::function<void(std::string_view phase, std::uint64_t done, std::uint64_t total)>;

/// How a long call is watched: by a stop token, which ends it, by a function that hears how far it
/// has come, or by both. Either alone converts to it.
struct Watch {
  Watch() = default;
  Watch(std::stop_token requests, Progress report = {}) : stop(std::move(requests)), progress(std::move(report)) {}
  template <std::invocable<std::string_view, std::uint64_t, std::uint64_t> Report>
  Watch(Report report) : progress(std::move(report)) {}

  std::stop_token stop{};
  Progress progress{};
};

}  // namespace rhoray::RHORAY_ABI
