#include "formats/base/parallel.h"

#include <gtest/gtest.h>

#include <mutex>
#include <stdexcept>

namespace rhoray {
namespace {

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

}  // namespace
}  // namespace rhoray
