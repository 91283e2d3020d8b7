#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace rhoray {

/// Cuts [0, count) into at most `threads` neighbouring ranges of at least `smallest` and calls act(first, last) on all
/// of them at the same time; returns when all are done. What the lowest range that failed threw is thrown again.
/// @param threads  0 = all cores. One range, or no room for another thread, needs no thread beside the caller's.
template <class Act>
void for_each_range(std::uint64_t count, std::uint64_t smallest, unsigned threads, Act&& act) {
  const std::uint64_t wanted = threads != 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
  const std::uint64_t parts = std::clamp<std::uint64_t>(count / std::max<std::uint64_t>(smallest, 1), 1, wanted);
  const auto start = [&](std::uint64_t part) { return count / parts * part + std::min(part, count % parts); };

  std::vector<std::exception_ptr> failures(parts);
  const auto run = [&](std::uint64_t part) {
    try {
      act(start(part), start(part + 1));
    } catch (...) {
      failures[part] = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  others.reserve(parts - 1);
  for (std::uint64_t part = 1; part < parts; ++part) {
    try {
      others.emplace_back(run, part);
    } catch (const std::system_error&) {  // the system gives no more threads
      run(part);
    }
  }
  run(0);
  for (std::thread& other : others) other.join();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace rhoray
