#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/base/checks.h"

/// Parallel loops of all rooms, on std::thread: thread sanitizer follows every one of them. The
/// tiles of a frame have threads of their own (render/frame/tile_threads.h), which wait from frame
/// to frame. A loop's threads begin with the floating-point environment of its caller
/// (floating_point.h).
namespace rhoray {

/// Cores that this process may run on, at least 1.
unsigned available_cores();

/// How many threads the parallel loops of this process use together, the caller's among them: what
/// a ThreadLimit says, or available_cores().
unsigned thread_limit();

/// While it lives, thread_limit() is `threads`, or available_cores() for 0; then what it was
/// before. Not to be made while a loop runs.
class ThreadLimit {
 public:
  explicit ThreadLimit(unsigned threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  unsigned before_;
};

/// Indices begin() <= i < end() that one thread works on at a time.
class IndexRange {
 public:
  IndexRange(std::size_t begin, std::size_t end, unsigned worker) : begin_(begin), end_(end), worker_(worker) {}

  std::size_t begin() const { return begin_; }
  std::size_t end() const { return end_; }
  std::size_t size() const { return end_ - begin_; }
  /// Which of the loop's threads: below thread_limit(), never the same in two calls at a time.
  unsigned worker() const { return worker_; }

 private:
  std::size_t begin_, end_;
  unsigned worker_;
};

namespace parallel_details {

/// Calls run(piece, worker) once for every piece below `count`, on the caller's thread and on those
/// that the limit still allows; they take pieces in rising order. After a call has thrown no piece
/// is begun; what the lowest piece threw is thrown again when all have ended.
/// @param threads  at most so many; 0 = as many as the limit allows
void run_pieces(std::size_t count, unsigned threads,
                const std::function<void(std::size_t piece, unsigned worker)>& run);

/// Calls both, `second` on a thread of its own if the limit allows one. What `first` threw goes
/// before what `second` threw.
void run_both(const std::function<void()>& first, const std::function<void()>& second);

}  // namespace parallel_details

/// Cuts [0, count) into ranges of `grain` indices, the last one shorter, and calls act(IndexRange)
/// on each: many at a time, in no promised order. Where ranges begin does not depend on the number
/// of threads. A call that throws ends the loop, and what the lowest failing range threw is passed
/// on. Loops inside loops get the threads that are left.
/// @param grain    at least 1; worth some ten microseconds, so that taking a range costs nothing
///                 beside it
/// @param threads  at most so many; 0 = as many as the limit allows
template <class Act>
void parallel_for(std::size_t count, std::size_t grain, Act&& act, unsigned threads = 0) {
  RHORAY_CHECK(grain > 0);
  parallel_details::run_pieces(count / grain + (count % grain != 0), threads, [&](std::size_t piece, unsigned worker) {
    const std::size_t begin = piece * grain;
    act(IndexRange(begin, begin + std::min(grain, count - begin), worker));
  });
}

/// As parallel_for, calling act(index) for each index alone: where each is worth some ten
/// microseconds or more.
template <class Act>
void parallel_for_each(std::size_t count, Act&& act) {
  parallel_details::run_pieces(count, 0, [&](std::size_t index, unsigned) { act(index); });
}

/// What `of(IndexRange)` returns for each range of parallel_for, joined two and two in rising
/// order: the same for any number of threads, floating-point sums too.
/// @param none  the result of no range
template <class Result, class Of, class Join>
Result parallel_reduce(std::size_t count, std::size_t grain, Result none, Of&& of, Join&& join) {
  static_assert(!std::is_same_v<Result, bool>, "std::vector<bool> has no elements that threads may write");
  RHORAY_CHECK(grain > 0);
  std::vector<Result> parts(count / grain + (count % grain != 0), none);
  parallel_for(count, grain, [&](const IndexRange& part) { parts[part.begin() / grain] = of(part); });
  for (const Result& part : parts) none = join(std::move(none), part);
  return none;
}

/// Calls first() and second(), at the same time where the limit allows another thread. What first()
/// throws goes before what second() throws; both have ended then.
template <class First, class Second>
void parallel_invoke(First&& first, Second&& second) {
  parallel_details::run_both(std::ref(first), std::ref(second));
}

/// As std::sort. Equal values end up in an order that depends on the number of threads only if
/// `less` leaves some equal that are not.
template <class T, class Less>
void parallel_sort(std::span<T> values, const Less& less) {
  constexpr std::size_t grain = 1 << 13;
  if (values.size() <= grain || thread_limit() == 1) {
    std::sort(values.begin(), values.end(), less);
    return;
  }
  // One step of quicksort, its pivot the middle of three. Where it divides badly, std::nth_element
  // halves exactly.
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::array<T, 3> sample{values.front(), *middle, values.back()};
  std::sort(sample.begin(), sample.end(), less);
  auto cut = std::partition(values.begin(), values.end(), [&](const T& value) { return less(value, sample[1]); });
  const auto first_count = static_cast<std::size_t>(cut - values.begin());
  if (std::min(first_count, values.size() - first_count) < values.size() / 8) {
    std::nth_element(values.begin(), middle, values.end(), less);
    cut = middle;
  }
  const auto at = static_cast<std::size_t>(cut - values.begin());
  parallel_invoke([&] { parallel_sort(values.first(at), less); }, [&] { parallel_sort(values.subspan(at), less); });
}

/// One T for each thread of a loop: buffers, counts. Made when a thread first asks for its own.
template <class T>
class PerWorker {
 public:
  template <class Make>
  explicit PerWorker(Make make) : make_(std::move(make)), values_(thread_limit()) {}

  /// The one of the thread that works on this range.
  T& of(const IndexRange& range) {
    RHORAY_CHECK(range.worker() < values_.size());  // not if a ThreadLimit was made in between
    std::unique_ptr<T>& value = values_[range.worker()];
    if (!value) value.reset(new T(make_()));  // not moved: T need not be movable
    return *value;
  }

  /// Calls act(T&) for those that were made; after the loop.
  template <class Act>
  void for_each(Act&& act) {
    for (const std::unique_ptr<T>& value : values_)
      if (value) act(*value);
  }

 private:
  std::function<T()> make_;
  std::vector<std::unique_ptr<T>> values_;
};

/// Cuts [0, count) into at most `threads` neighbouring ranges of at least `smallest` and calls
/// act(first, last) on all of them at the same time; returns when all are done. What the lowest
/// range that failed threw is thrown again.
/// @param threads  0 = thread_limit(). One range, or no room for another thread, needs no thread
///                 beside the caller's.
template <class Act>
void for_each_range(std::uint64_t count, std::uint64_t smallest, unsigned threads, Act&& act) {
  const std::uint64_t wanted = threads != 0 ? threads : thread_limit();
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
    } catch (...) {  // no more threads, or no memory for one
      run(part);
    }
  }
  run(0);
  for (std::thread& other : others) other.join();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace rhoray
