#include "render/traverse/maximum_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::MaximumQueue;

/// The order, in words: larger bound first; then nearer; a found value before a region; the cell
/// entered first; smaller id.
auto rank(const MaximumQueue::Entry& e) {
  const bool is_found = e.level == MaximumQueue::found;
  return std::tuple(-e.bound, e.t_in, is_found ? 0 : 1, is_found ? e.t_out : 0.0, e.id);
}

TEST(MaximumQueue, gives_entries_back_by_bound_then_nearness_then_found_first_whatever_the_order_of_insertion) {
  Dice dice(5);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<MaximumQueue::Entry> entries;
    for (int e = 0; e < 60; ++e) {
      MaximumQueue::Entry entry;
      entry.bound = static_cast<double>(dice.below(4)) - 2;
      entry.t_in = static_cast<double>(dice.below(4));
      entry.level = static_cast<int>(dice.below(3)) - 1;
      entry.t_out = static_cast<double>(dice.below(2));
      entry.id = static_cast<std::uint64_t>(e);
      entries.push_back(entry);
    }
    std::shuffle(entries.begin(), entries.end(), std::mt19937_64(static_cast<std::uint64_t>(trial)));
    MaximumQueue queue;
    for (const auto& entry : entries) queue.push(entry);
    std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return rank(a) < rank(b); });
    for (const auto& expected : entries) {
      ASSERT_FALSE(queue.is_empty());
      ASSERT_EQ(rank(queue.pop()), rank(expected));
    }
    EXPECT_TRUE(queue.is_empty());
  }
}

TEST(MaximumQueue, keeps_its_memory_when_it_is_cleared) {
  MaximumQueue queue;
  queue.reserve(100);
  const std::size_t capacity = queue.capacity();
  for (int round = 0; round < 3; ++round) {
    for (int e = 0; e < 100; ++e) queue.push(MaximumQueue::Entry{});
    EXPECT_EQ(queue.capacity(), capacity);
    queue.clear();
    EXPECT_TRUE(queue.is_empty());
  }
}

}  // namespace
}  // namespace rhoray::tests
