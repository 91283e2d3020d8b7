#pragma once

#include <algorithm>
#include <cstdint>
#include <stop_token>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "formats/base/progress.h"

namespace rhoray {

[[noreturn]] inline void throw_interrupted() {
  throw Error(ErrorCode::interrupted, "interrupted");
}

/// Throws ErrorCode::interrupted if a stop was requested.
inline void end_if_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw_interrupted();
}

/// Indices of a loop between two looks for a stop request, if an index takes some nanoseconds.
inline constexpr std::uint64_t light_piece = 1 << 12;

/// Calls act(index) for first <= index < last, in order. Throws ErrorCode::interrupted at the first
/// multiple of `piece` after a stop was requested.
/// @param piece  at least 1; should take much longer than reading the token, and at most a
///               millisecond
/// @param meter  null, or what counts the indices
template <class Act>
void for_each_until_stopped(std::uint64_t first, std::uint64_t last, std::uint64_t piece, const std::stop_token& stop,
                            Act&& act, ProgressMeter* meter = nullptr) {
  for (std::uint64_t begin = first; begin < last;) {
    end_if_stopped(stop);
    const std::uint64_t end = std::min(begin + piece - begin % piece, last), count = end - begin;
    for (; begin < end; ++begin) act(begin);
    if (meter != nullptr) meter->add(count);
  }
}

/// As above for all indices below `count`, on the threads of for_each_range. Every thread ends.
template <class Act>
void for_each_until_stopped(std::uint64_t count, std::uint64_t smallest, std::uint64_t piece, unsigned threads,
                            const std::stop_token& stop, Act&& act, ProgressMeter* meter = nullptr) {
  for_each_range(count, smallest, threads, [&](std::uint64_t first, std::uint64_t last) {
    for_each_until_stopped(first, last, piece, stop, act, meter);
  });
}

}  // namespace rhoray
