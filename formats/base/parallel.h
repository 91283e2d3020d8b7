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

/// Parallel loops of all modules, on std::thread: thread sanitizer can follow all of them. The
/// tiles of a frame have their own threads (render/frame/tile_threads.h), which wait between
/// frames. A loop's threads start with the floating-point environment of its caller
/// (floating_point.h).
namespace rhoray {

/// Cores that this process may run on, at least 1.
unsigned available_cores();

/// The number of threads that the parallel loops of this process use together, including the
/// caller's: the value of a ThreadLimit, or available_cores().
unsigned thread_limit();

/// While it lives, thread_limit() is `threads`, or available_cores() for 0. Its destructor restores
/// the previous limit. Do not create one while a loop runs.
class ThreadLimit {
 public:
  explicit ThreadLimit(unsigned threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  unsigned before_;
};

/// A range of indices begin() <= i < end() that one thread processes at a time.
class IndexRange {
 public:
  IndexRange(std::size_t begin, std::size_t end, unsigned worker) : begin_(begin), end_(end), worker_(worker) {}

  std::size_t begin() const { return begin_; }
  std::size_t end() const { return end_; }
  std::size_t size() const { return end_ - begin_; }
  /// Index of the thread within the loop: below thread_limit(), never shared by two calls at a
  /// time.
  unsigned worker() const { return worker_; }

 private:
  std::size_t begin_, end_;
  unsigned worker_;
};

namespace parallel_details {

/// Calls run(piece, worker) once for every piece below `count`, on the caller's thread and on as
/// many others as the limit still allows. Threads take pieces in increasing order. After a call
/// throws, no further piece starts. When all have ended, the exception of the lowest failing piece
/// is rethrown.
/// @param threads  upper limit; 0 = as many as the limit allows
void run_pieces(std::size_t count, unsigned threads,
                const std::function<void(std::size_t piece, unsigned worker)>& run);

/// Calls both, `second` on its own thread if the limit allows one. An exception of `first` takes
/// precedence over one of `second`.
void run_both(const std::function<void()>& first, const std::function<void()>& second);

}  // namespace parallel_details

/// Cuts [0, count) into ranges of `grain` indices, the last one shorter, and calls act(IndexRange)
/// on each. Several calls run at a time, in no promised order. The ranges do not depend on the
/// number of threads. A call that throws ends the loop, and the exception of the lowest failing
/// range is rethrown. Nested loops get the threads that are left.
/// @param grain    at least 1; about ten microseconds of work, so that the cost of taking a range
///                 is negligible
/// @param threads  upper limit; 0 = as many as the limit allows
template <class Act>
void parallel_for(std::size_t count, std::size_t grain, Act&& act, unsigned threads = 0) {
  RHORAY_CHECK(grain > 0);
  parallel_details::run_pieces(count / grain + (count % grain != 0), threads, [&](std::size_t piece, unsigned worker) {
    const std::size_t begin = piece * grain;
    act(IndexRange(begin, begin + std::min(grain, count - begin), worker));
  });
}

/// Like parallel_for, but calls act(index) for each index. Use it where each index takes about ten
/// microseconds or more.
template <class Act>
void parallel_for_each(std::size_t count, Act&& act) {
  parallel_details::run_pieces(count, 0, [&](std::size_t index, unsigned) { act(index); });
}

/// Joins the results of `of(IndexRange)` for the ranges of parallel_for pairwise, in increasing
/// order. The result is the same for any number of threads, also for floating-point sums.
/// @param none  the result for no range
template <class Result, class Of, class Join>
Result parallel_reduce(std::size_t count, std::size_t grain, Result none, Of&& of, Join&& join) {
  static_assert(!std::is_same_v<Result, bool>, "std::vector<bool> has no elements that threads may write");
  RHORAY_CHECK(grain > 0);
  std::vector<Result> parts(count / grain + (count % grain != 0), none);
  parallel_for(count, grain, [&](const IndexRange& part) { parts[part.begin() / grain] = of(part); });
  for (const Result& part : parts) none = join(std::move(none), part);
  return none;
}

/// Calls first() and second(), concurrently if the limit allows another thread. Both have ended
/// when it returns or throws. An exception of first() takes precedence over one of second().
template <class First, class Second>
void parallel_invoke(First&& first, Second&& second) {
  parallel_details::run_both(std::ref(first), std::ref(second));
}

/// Like std::sort. The order of equal values depends on the number of threads only if `less` treats
/// different values as equal.
template <class T, class Less>
void parallel_sort(std::span<T> values, const Less& less) {
  constexpr std::size_t grain = 1 << 13;
  if (values.size() <= grain || thread_limit() == 1) {
    std::sort(values.begin(), values.end(), less);
    return;
  }
  // One step of quicksort with the median of three as pivot. Where the pivot divides badly,
  // std::nth_element halves exactly.
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

/// One T per thread of a loop: buffers, counts. Created when a thread first uses its own.
template <class T>
class PerWorker {
 public:
  template <class Make>
  explicit PerWorker(Make make) : make_(std::move(make)), values_(thread_limit()) {}

  /// The T of the thread that processes this range.
  T& of(const IndexRange& range) {
    RHORAY_CHECK(range.worker() < values_.size());  // fails if a ThreadLimit was made in between
    std::unique_ptr<T>& value = values_[range.worker()];
    if (!value) value.reset(new T(make_()));  // not moved: T need not be movable
    return *value;
  }

  /// Calls act(T&) for each T that was created. Call it after the loop.
  template <class Act>
  void for_each(Act&& act) {
    for (const std::unique_ptr<T>& value : values_)
      if (value) act(*value);
  }

 private:
  std::function<T()> make_;
  std::vector<std::unique_ptr<T>> values_;
};

/// Cuts [0, count) into at most `threads` adjacent ranges of at least `smallest` indices and calls
/// act(first, last) on all of them concurrently. Returns when all are done. Rethrows the exception
/// of the lowest failing range.
/// @param threads  0 = thread_limit(). With one range, or when the limit allows no other thread,
///                 only the caller's thread is used.
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
