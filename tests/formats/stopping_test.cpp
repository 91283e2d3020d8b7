#include "formats/base/stopping.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

#include "formats/base/stoppable_mutex.h"
#include "tests/support/expect_error.h"

// Loops that a caller can stop. Their work after a stop request is counted.

namespace rhoray {
namespace {

using tests::expect_error;

TEST(ForEachUntilStopped, calls_every_index_once_in_order_without_a_request) {
  for (const std::uint64_t first : {0U, 1U, 7U, 8U, 9U})
    for (const std::uint64_t last : {0U, 1U, 8U, 9U, 30U})
      for (const std::uint64_t piece : {1U, 4U, 8U, 100U}) {
        std::vector<std::uint64_t> called, expected(last > first ? last - first : 0);
        std::iota(expected.begin(), expected.end(), first);
        for_each_until_stopped(first, last, piece, {}, [&](std::uint64_t i) { called.push_back(i); });
        EXPECT_EQ(called, expected) << first << ", " << last << ", " << piece;
      }
}

TEST(ForEachUntilStopped, calls_nothing_after_a_request) {
  std::stop_source stop;
  stop.request_stop();
  std::atomic<int> calls = 0;
  const auto count = [&](std::uint64_t) { ++calls; };
  expect_error(ErrorCode::interrupted, "interrupted",
               [&] { for_each_until_stopped(0, 100, 8, stop.get_token(), count); });
  for (const unsigned threads : {1U, 3U})
    expect_error(ErrorCode::interrupted, "interrupted",
                 [&] { for_each_until_stopped(100, 1, 8, threads, stop.get_token(), count); });
  EXPECT_EQ(calls, 0);
}

TEST(ForEachUntilStopped, ends_at_the_next_multiple_of_a_piece) {
  for (const std::uint64_t first : {0U, 3U})
    for (const std::uint64_t at : {3U, 7U, 8U, 15U, 16U, 40U}) {
      std::stop_source stop;
      std::uint64_t last_called = 0;
      expect_error(ErrorCode::interrupted, "interrupted", [&] {
        for_each_until_stopped(first, 100, 8, stop.get_token(), [&](std::uint64_t i) {
          last_called = i;
          if (i == at) stop.request_stop();
        });
      });
      EXPECT_EQ(last_called, at / 8 * 8 + 7);
    }
  // A request during the last piece comes too late.
  std::stop_source stop;
  EXPECT_NO_THROW(for_each_until_stopped(0, 20, 8, stop.get_token(), [&](std::uint64_t i) {
    if (i == 16) stop.request_stop();
  }));
}

TEST(ForEachUntilStopped, lets_every_thread_finish_one_piece) {
  constexpr unsigned threads = 3;
  std::stop_source stop;
  std::atomic<int> calls = 0;
  expect_error(ErrorCode::interrupted, "interrupted", [&] {
    for_each_until_stopped(threads * 80, 1, 8, threads, stop.get_token(), [&](std::uint64_t i) {
      ++calls;
      if (i == 0) stop.request_stop();
      while (!stop.stop_requested()) std::this_thread::yield();
    });
  });
  EXPECT_GE(calls, 8);
  EXPECT_LE(calls, static_cast<int>(threads * 8));
}

TEST(StoppableMutex, lets_one_caller_in_at_a_time) {
  StoppableMutex mutex;
  int count = 0;
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread)
      threads.emplace_back([&](const std::stop_token& stop) {
        for (int time = 0; time < 1000; ++time) {
          const StoppableLock lock(mutex, stop);
          const int before = count;
          std::this_thread::yield();
          count = before + 1;
        }
      });
    for (std::jthread& thread : threads) thread.join();
  }
  EXPECT_EQ(count, 4000);
}

/// Gives threads the time to begin to wait.
void let_wait() {
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

TEST(StoppableMutex, wakes_each_waiter_in_turn) {
  for (int time = 0; time < 50; ++time) {
    StoppableMutex mutex;
    mutex.lock({});
    std::jthread first([&] { StoppableLock(mutex, {}); });
    std::jthread second([&] { StoppableLock(mutex, {}); });
    let_wait();
    mutex.unlock();
    first.join();  // or waits for ever
    second.join();
  }
}

TEST(StoppableMutex, ends_the_waiting_after_a_stop_request) {
  StoppableMutex mutex;
  mutex.lock({});
  std::stop_source stop;
  std::jthread waiter(
      [&] { expect_error(ErrorCode::interrupted, "interrupted", [&] { StoppableLock(mutex, stop.get_token()); }); });
  let_wait();
  stop.request_stop();
  waiter.join();
  mutex.unlock();
  const StoppableLock lock(mutex, stop.get_token());  // nobody holds it: a request changes nothing
}

TEST(StoppableMutex, wakes_another_waiter_if_one_is_stopped_as_the_mutex_is_released) {
  for (int time = 0; time < 50; ++time) {
    StoppableMutex mutex;
    std::stop_source stop;
    mutex.lock({});
    std::jthread other([&] { StoppableLock(mutex, {}); });
    std::jthread stopped([&] {
      try {
        StoppableLock(mutex, stop.get_token());
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::interrupted);
      }
    });
    let_wait();
    std::jthread stopping([&] { stop.request_stop(); });
    mutex.unlock();
    other.join();  // or waits for ever
    stopped.join();
    stopping.join();
  }
}

}  // namespace
}  // namespace rhoray
