#include "preprocess/process/scratch_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/neutral.h"
#include "preprocess/process/memory_cap.h"
#include "preprocess/process/nameless_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using tests::TemporaryFolder;

constexpr std::size_t mebibyte = std::size_t{1} << 20;

/// RssAnon of this process.
std::uint64_t anonymous_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) return std::stoull(line.substr(8)) << 10;
  return 0;
}

std::size_t files_in(const TemporaryFolder& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) ++count;
  return count;
}

TEST(ScratchMemory, holds_large_arrays_outside_anonymous_memory_and_without_a_name) {
  const TemporaryFolder folder;
  ScratchMemory scratch(folder.path());
  const std::uint64_t before = anonymous_bytes();
  Array<std::uint64_t> numbers(4 * mebibyte, &scratch);  // 32 MiB, touched by filling it
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i * i;
  EXPECT_EQ(files_in(folder), 0U);
#if !defined(__SANITIZE_THREAD__)  // which notes each access in memory of its own
  EXPECT_LT(anonymous_bytes(), before + 4 * mebibyte);
#endif
  numbers.resize(5 * mebibyte);  // moves into a larger file
  for (std::size_t i = 0; i < 4 * mebibyte; i += 1000) ASSERT_EQ(numbers[i], i * i);
  EXPECT_EQ(numbers.back(), 0U);

  const Array<std::uint64_t> on_the_heap(4 * mebibyte, 1);
  EXPECT_GE(anonymous_bytes(), before + 32 * mebibyte) << "the counter does not see anonymous memory";
  EXPECT_EQ(on_the_heap.back(), 1U);
}

TEST(ScratchMemory, takes_small_blocks_from_the_heap) {
  const TemporaryFolder folder;
  ScratchMemory scratch(folder.path() / "that is not there");
  Array<std::byte> small(ScratchMemory::smallest_block - 1, &scratch);
  EXPECT_EQ(small.back(), std::byte{0});
  tests::expect_error(ErrorCode::resource, "that is not there",
                      [&] { Array<std::byte>(ScratchMemory::smallest_block, &scratch); });
}

TEST(ScratchMemory, serves_several_threads) {
  const TemporaryFolder folder;
  ScratchMemory scratch(folder.path());
  std::vector<std::thread> threads;
  std::array<bool, 4> right{};
  for (std::size_t t = 0; t < right.size(); ++t)
    threads.emplace_back([&, t] {
      right[t] = true;
      for (int round = 0; round < 20; ++round) {
        Array<std::uint64_t> numbers(mebibyte / 4, t, &scratch);
        right[t] = right[t] && numbers.front() == t && numbers.back() == t;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(right, testing::Each(true));
}

TEST(NamelessFile, has_its_space_and_no_name) {
  const TemporaryFolder folder;
  const int descriptor = open_nameless_file(folder.path(), 3 * mebibyte);
  struct stat facts {};
  ASSERT_EQ(::fstat(descriptor, &facts), 0);
  EXPECT_EQ(facts.st_nlink, 0U);
  EXPECT_EQ(static_cast<std::uint64_t>(facts.st_size), 3 * mebibyte);
  EXPECT_GE(static_cast<std::uint64_t>(facts.st_blocks) * 512, 3 * mebibyte);
  ::close(descriptor);
}

TEST(NamelessFile, refuses_more_than_the_disk_has) {
  const TemporaryFolder folder;
  tests::expect_error(ErrorCode::resource, folder.path().string(),
                      [&] { open_nameless_file(folder.path(), std::uint64_t{1} << 60); });
}

TEST(MemoryCap, moves_arrays_to_the_folder_while_it_lives_and_bounds_the_rest) {
  if (tests::sanitized) GTEST_SKIP() << tests::no_limits_of_memory;
  const TemporaryFolder folder;
  rlimit before{}, during{}, after{};
  ASSERT_EQ(::getrlimit(RLIMIT_DATA, &before), 0);
  {
    const MemoryCap cap(MemoryCap::smallest_bytes, folder.path());
    ASSERT_EQ(::getrlimit(RLIMIT_DATA, &during), 0);
    const std::uint64_t anonymous = anonymous_bytes();
    const Array<std::byte> large(64 * mebibyte, std::byte{1});
    EXPECT_LT(anonymous_bytes(), anonymous + 4 * mebibyte);
    EXPECT_EQ(large.back(), std::byte{1});
    EXPECT_THROW(std::vector<std::byte>(during.rlim_cur), std::bad_alloc);
  }
  ASSERT_EQ(::getrlimit(RLIMIT_DATA, &after), 0);
  EXPECT_LT(during.rlim_cur, before.rlim_cur);
  EXPECT_EQ(after.rlim_cur, before.rlim_cur);
  EXPECT_EQ(std::pmr::get_default_resource(), std::pmr::new_delete_resource());
}

TEST(MemoryCap, refuses_what_programs_take_by_themselves) {
  const TemporaryFolder folder;
  tests::expect_error(ErrorCode::usage, "expected at least 16M",
                      [&] { const MemoryCap cap(MemoryCap::smallest_bytes - 1, folder.path()); });
}

TEST(MemoryCap, knows_folders_that_are_memory) {
  EXPECT_FALSE(MemoryCap::folder_is_memory("/proc"));
  EXPECT_FALSE(MemoryCap::folder_is_memory("/no/such/folder"));
  std::ifstream mounts("/proc/mounts");
  std::string place, kind;
  for (std::string source, rest; mounts >> source >> place >> kind && std::getline(mounts, rest);)
    if (kind == "tmpfs" && std::filesystem::is_directory(place)) {
      EXPECT_TRUE(MemoryCap::folder_is_memory(place)) << place;
      return;
    }
  GTEST_SKIP() << "no folder of this system lies in memory";
}

}  // namespace
}  // namespace rhoray::preprocess
