#include "formats/base/parallel.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

namespace rhoray {
namespace {

/// Lets each of `count` threads pass once all have arrived; false for a thread that waited in vain.
class Meeting {
 public:
  explicit Meeting(unsigned count) : missing_(count) {}

  bool come() {
    std::unique_lock lock(mutex_);
    if (--missing_ == 0) all_here_.notify_all();
    return all_here_.wait_for(lock, std::chrono::seconds(60), [&] { return missing_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable all_here_;
  unsigned missing_;
};

/// Counts how many threads are inside at the same time.
class Crowd {
 public:
  void enter() {
    const unsigned now = ++inside_;
    for (unsigned most = most_; most < now && !most_.compare_exchange_weak(most, now);) continue;
  }
  void leave() { --inside_; }
  unsigned most() const { return most_; }

 private:
  std::atomic<unsigned> inside_{0}, most_{0};
};

TEST(ForEachRange, ranges_cover_everything_once) {
  for (const std::uint64_t count : {0, 1, 2, 7, 100, 1001})
    for (const unsigned threads : {0U, 1U, 3U, 16U}) {
      std::vector<int> seen(count);
      std::mutex guard;
      std::size_t ranges = 0;
      for_each_range(count, 5, threads, [&](std::uint64_t first, std::uint64_t last) {
        const std::lock_guard lock(guard);
        ++ranges;
        for (std::uint64_t i = first; i < last; ++i) ++seen[i];
      });
      EXPECT_EQ(seen, std::vector<int>(count, 1));
      EXPECT_LE(ranges, threads != 0 ? threads : 1000U);
      EXPECT_LE(ranges, count / 5 + 1) << "no range is smaller than asked for";
    }
}

TEST(ForEachRange, the_failure_of_the_lowest_range_comes_out) {
  const auto fail_in_all = [](std::uint64_t first, std::uint64_t) { throw std::runtime_error(std::to_string(first)); };
  try {
    for_each_range(100, 1, 4, fail_in_all);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "0");
  }
}

TEST(ParallelFor, ranges_cover_everything_once_and_begin_at_the_same_places_for_any_number_of_threads) {
  for (const unsigned threads : {1U, 2U, 7U}) {
    const ThreadLimit limit(threads);
    for (const std::size_t count : {0, 1, 4, 5, 6, 1001}) {
      std::vector<int> seen(count);
      std::set<std::size_t> begins;
      std::mutex guard;
      parallel_for(count, 5, [&](const IndexRange& part) {
        const std::lock_guard lock(guard);
        EXPECT_LT(part.worker(), threads);
        EXPECT_TRUE(part.size() == 5 || part.end() == count);
        EXPECT_TRUE(begins.insert(part.begin()).second && part.begin() % 5 == 0);
        for (std::size_t i = part.begin(); i < part.end(); ++i) ++seen[i];
      });
      EXPECT_EQ(seen, std::vector<int>(count, 1));
      EXPECT_EQ(begins.size(), (count + 4) / 5);
    }
  }
}

TEST(ParallelFor, works_on_as_many_threads_as_the_limit_says) {
  for (const unsigned threads : {1U, 3U, 8U}) {
    const ThreadLimit limit(threads);
    EXPECT_EQ(thread_limit(), threads);
    Meeting meeting(threads);
    std::atomic<unsigned> met{0};
    parallel_for_each(threads, [&](std::size_t) { met += meeting.come(); });
    EXPECT_EQ(met, threads) << "they did not work at the same time";
  }
}

TEST(ParallelFor, loops_inside_loops_stay_within_the_limit_together) {
  const ThreadLimit limit(3);
  Crowd crowd;
  std::atomic<int> calls{0};
  parallel_for_each(20, [&](std::size_t) {
    parallel_for_each(20, [&](std::size_t) {
      crowd.enter();
      ++calls;
      std::this_thread::yield();
      crowd.leave();
    });
  });
  EXPECT_EQ(calls, 400);
  EXPECT_LE(crowd.most(), 3U);
}

TEST(ParallelFor, may_be_told_to_use_fewer_threads_than_the_limit) {
  const ThreadLimit limit(8);
  Crowd crowd;
  std::atomic<unsigned> highest{0};
  const auto act = [&](const IndexRange& part) {
    crowd.enter();
    for (unsigned most = highest; most < part.worker() && !highest.compare_exchange_weak(most, part.worker());)
      continue;
    std::this_thread::yield();
    crowd.leave();
  };
  parallel_for(1000, 1, act, 2);
  EXPECT_LE(crowd.most(), 2U);
  EXPECT_LT(highest, 2U);
}

TEST(ParallelFor, passes_on_what_the_lowest_failing_range_threw_and_begins_no_other) {
  for (const unsigned threads : {1U, 4U}) {
    const ThreadLimit limit(threads);
    std::atomic<std::size_t> begun{0};
    try {
      parallel_for_each(1'000'000, [&](std::size_t index) {
        ++begun;
        if (index >= 30) throw std::runtime_error(std::to_string(index));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "30");
    }
    EXPECT_LT(begun, 1'000'000U);
    std::atomic<std::size_t> later{0};
    parallel_for_each(100, [&](std::size_t) { ++later; });
    EXPECT_EQ(later, 100U) << "a failure leaves nothing behind";
  }
}

TEST(ParallelFor, two_loops_at_once_do_not_meet) {
  const ThreadLimit limit(4);
  std::vector<std::uint64_t> sums(8);
  std::vector<std::thread> callers;
  for (std::uint64_t& sum : sums)
    callers.emplace_back([&sum] {
      sum = parallel_reduce(
          100'000, 64, std::uint64_t{0},
          [](const IndexRange& part) {
            std::uint64_t of_part = 0;
            for (std::size_t i = part.begin(); i < part.end(); ++i) of_part += i;
            return of_part;
          },
          [](std::uint64_t a, std::uint64_t b) { return a + b; });
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sums, std::vector<std::uint64_t>(8, 100'000ULL * 99'999 / 2));
}

TEST(ParallelReduce, adds_floating_point_numbers_in_one_order_on_any_number_of_threads) {
  std::vector<double> values(50'000);
  std::mt19937_64 random(3);
  for (double& value : values) value = std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 60) - 30);
  const auto sum = [&](unsigned threads) {
    const ThreadLimit limit(threads);
    return parallel_reduce(
        values.size(), 100, 0.0,
        [&](const IndexRange& part) {
          return std::accumulate(values.data() + part.begin(), values.data() + part.end(), 0.0);
        },
        [](double a, double b) { return a + b; });
  };
  const double once = sum(1);
  for (const unsigned threads : {2U, 3U, 8U}) EXPECT_EQ(sum(threads), once);
}

TEST(ParallelInvoke, calls_both_at_once_where_two_threads_are_allowed) {
  for (const unsigned threads : {1U, 2U}) {
    const ThreadLimit limit(threads);
    Meeting meeting(threads);
    int first = 0, second = 0;
    parallel_invoke([&] { first = 1 + (threads == 2 && meeting.come()); },
                    [&] { second = 1 + (threads == 2 && meeting.come()); });
    EXPECT_EQ(first, static_cast<int>(threads));
    EXPECT_EQ(second, static_cast<int>(threads));
  }
}

TEST(ParallelInvoke, waits_for_both_and_throws_what_the_first_threw) {
  for (const unsigned threads : {1U, 2U}) {
    const ThreadLimit limit(threads);
    bool second_ran = false;
    const auto second = [&] {
      second_ran = true;
      throw std::runtime_error("second");
    };
    try {
      parallel_invoke([] { throw std::runtime_error("first"); }, second);
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "first");
    }
    EXPECT_TRUE(second_ran);
    EXPECT_THROW(parallel_invoke([] {}, second), std::runtime_error);
  }
}

/// The lowest address of the calling thread's stack.
void* stack_of_this_thread() {
  pthread_attr_t attributes;
  void* lowest = nullptr;
  std::size_t bytes = 0;
  if (::pthread_getattr_np(::pthread_self(), &attributes) != 0) return nullptr;
  ::pthread_attr_getstack(&attributes, &lowest, &bytes);
  ::pthread_attr_destroy(&attributes);
  return lowest;
}

/// A thread keeps its stack until it is joined, and each caller in a recursion joins its own last.
TEST(ParallelInvoke, takes_one_stack_for_threads_that_run_one_after_another_in_a_recursion) {
  const ThreadLimit limit(2);
  const std::thread::id caller = std::this_thread::get_id();
  std::array<void*, 8> stacks{};  // null where no thread was started
  const std::function<void(std::size_t)> recurse = [&](std::size_t depth) {
    if (depth == stacks.size()) return;
    std::atomic<bool> second_ran = false;
    parallel_invoke(
        [&] {
          // until the other thread has ended, or for a while if none was started
          for (int wait = 0; wait < 100 && !second_ran; ++wait)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
          recurse(depth + 1);
        },
        [&] {
          if (std::this_thread::get_id() != caller) stacks[depth] = stack_of_this_thread();
          second_ran = true;
        });
  };
  recurse(0);
  std::set<void*> used(stacks.begin(), stacks.end());
  EXPECT_LE(std::count(stacks.begin(), stacks.end(), nullptr), 4) << "hardly a thread was started";
  used.erase(nullptr);
  EXPECT_EQ(used.size(), 1U);
}

TEST(ParallelSort, sorts_as_std_sort_does) {
  const ThreadLimit limit(4);
  std::mt19937_64 random(5);
  const std::size_t count = 100'000;
  std::vector<std::uint64_t> rising(count), shuffled(count), few(count), equal(count, 7);
  std::iota(rising.begin(), rising.end(), 0U);
  for (std::uint64_t& value : shuffled) value = random();
  for (std::uint64_t& value : few) value = random() % 3;
  std::vector<std::uint64_t> falling(rising.rbegin(), rising.rend());
  for (std::vector<std::uint64_t> values : {rising, falling, shuffled, few, equal, std::vector<std::uint64_t>{}}) {
    std::vector<std::uint64_t> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    parallel_sort(std::span(values), std::less<>());
    EXPECT_TRUE(values == sorted);
  }
}

TEST(PerWorker, has_one_value_for_each_thread) {
  const ThreadLimit limit(4);
  int made = 0;
  std::mutex guard;
  PerWorker<std::uint64_t> sums([&] {
    const std::lock_guard lock(guard);
    ++made;
    return std::uint64_t{0};
  });
  parallel_for(100'000, 10, [&](const IndexRange& part) {
    for (std::size_t i = part.begin(); i < part.end(); ++i) sums.of(part) += i;
  });
  std::uint64_t sum = 0;
  sums.for_each([&](std::uint64_t of_thread) { sum += of_thread; });
  EXPECT_EQ(sum, 100'000ULL * 99'999 / 2);
  EXPECT_GE(made, 1);
  EXPECT_LE(made, 4);
}

TEST(ThreadLimit, is_what_it_was_before_when_it_ends) {
  const unsigned before = thread_limit();
  {
    const ThreadLimit outer(5);
    {
      const ThreadLimit inner(2);
      EXPECT_EQ(thread_limit(), 2U);
    }
    EXPECT_EQ(thread_limit(), 5U);
    const ThreadLimit all(0);
    EXPECT_EQ(thread_limit(), available_cores());
  }
  EXPECT_EQ(thread_limit(), before);
}

}  // namespace
}  // namespace rhoray
