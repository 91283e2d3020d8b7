#include "preprocess/pack_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <barrier>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "formats/base/error.h"
#include "formats/brick_grid.h"
#include "preprocess/open_data.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

namespace fs = std::filesystem;
using preprocess::OpenedData;
using preprocess::PackCache;

/// A folder of files, and a cache beside it.
class PackCacheTest : public testing::Test {
 protected:
  PackCacheTest() {
    ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
    ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
    fs::create_directory(folder_ / "data");
    write_volume("a.mhd", 'a');
  }

  fs::path data(const std::string& name) const { return folder_ / "data" / name; }

  /// A MetaImage of 4 x 4 x 4 bytes, whose samples are in a file of their own.
  void write_volume(const std::string& name, char value) const {
    const std::string samples = fs::path(name).replace_extension(".raw");
    write_file(data(name),
               "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n"
               "ElementDataFile = " +
                   samples + "\n");
    std::string bytes(64, value);
    bytes[0] = 0;
    write_file(data(samples), bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(60));  // younger files are not kept
  }

  static double largest(const formats::PackedFile& file) {
    return formats::BrickGrid(file).description().fields.front().range.hi;
  }
  static double largest(const OpenedData& opened) { return largest(opened.file); }

  preprocess::PackReport pack_a(const formats::Destination& destination) const {
    return preprocess::pack(data("a.mhd"), destination);
  }

  std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(cache_folder()), fs::directory_iterator()));
  }
  fs::path cache_folder() const { return folder_ / "cache" / "rhoray"; }

  TemporaryFolder folder_;
};

TEST_F(PackCacheTest, packs_a_file_once) {
  fs::create_directories(cache_folder());
  fs::permissions(cache_folder(), fs::perms(0755));
  const OpenedData first = preprocess::open_data(data("a.mhd"));
  EXPECT_TRUE(first.was_packed);
  EXPECT_EQ(first.not_kept, "");
  const OpenedData second = preprocess::open_data(data("a.mhd"));
  EXPECT_FALSE(second.was_packed);
  EXPECT_EQ(second.path, first.path);
  EXPECT_EQ(largest(second), 'a');
  EXPECT_EQ(second.file.name(), data("a.mhd").string());
  struct stat facts {};
  ASSERT_EQ(::stat(cache_folder().c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 07777, 0700U);
}

TEST_F(PackCacheTest, packs_again_when_a_file_that_the_input_names_has_changed) {
  preprocess::open_data(data("a.mhd"));
  write_volume("a.mhd", 'b');
  fs::rename(data("a.mhd"), data("c.mhd"));  // the header keeps its inode, size and content
  fs::rename(data("c.mhd"), data("a.mhd"));
  const OpenedData again = preprocess::open_data(data("a.mhd"));
  EXPECT_TRUE(again.was_packed);
  EXPECT_EQ(largest(again), 'b');
  // only the samples: the header is untouched, and their size stays
  std::string bytes(64, 'c');
  bytes[0] = 0;
  write_file(data("a.raw"), bytes);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  const OpenedData changed = preprocess::open_data(data("a.mhd"));
  EXPECT_TRUE(changed.was_packed);
  EXPECT_EQ(largest(changed), 'c');
  EXPECT_FALSE(preprocess::open_data(data("a.mhd")).was_packed);
}

TEST_F(PackCacheTest, notices_a_change_that_keeps_size_and_modification_time) {
  preprocess::open_data(data("a.mhd"));
  const auto time = fs::last_write_time(data("a.raw"));
  std::string bytes(64, 'd');
  bytes[0] = 0;
  write_file(data("a.raw"), bytes);
  fs::last_write_time(data("a.raw"), time);
  EXPECT_EQ(largest(preprocess::open_data(data("a.mhd"))), 'd');
}

TEST_F(PackCacheTest, keeps_no_copy_of_samples_that_changed_a_moment_before) {
  // The samples could change again within the same tick of the file system's clock.
  std::string bytes(64, 'e');
  bytes[0] = 0;
  write_file(data("a.raw"), bytes);
  const OpenedData opened = preprocess::open_data(data("a.mhd"));
  EXPECT_EQ(opened.not_kept, "its files were changing");
  EXPECT_EQ(largest(opened), 'e');
  bytes.assign(64, 'f');
  bytes[0] = 0;
  write_file(data("a.raw"), bytes);
  EXPECT_EQ(largest(preprocess::open_data(data("a.mhd"))), 'f');
}

TEST_F(PackCacheTest, tells_versions_of_the_program_and_fields_apart) {
  preprocess::open_data(data("a.mhd"), {.program = "1"});
  EXPECT_TRUE(preprocess::open_data(data("a.mhd"), {.program = "2"}).was_packed);
  EXPECT_FALSE(preprocess::open_data(data("a.mhd"), {.program = "2"}).was_packed);
}

// Names are hashes, which may collide.
TEST_F(PackCacheTest, takes_no_record_of_another_version_that_has_its_name) {
  preprocess::open_data(data("a.mhd"), {.program = "1"});
  std::string first;
  for (const auto& entry : fs::directory_iterator(cache_folder()))
    if (entry.path().extension() == ".json") first = read_file(entry.path());
  ASSERT_NE(first.find("\"program\": \"1\""), first.npos);
  preprocess::open_data(data("a.mhd"), {.program = "2"});
  for (const auto& entry : fs::directory_iterator(cache_folder()))
    if (entry.path().extension() == ".json") write_file(entry.path(), first);
  EXPECT_TRUE(preprocess::open_data(data("a.mhd"), {.program = "2"}).was_packed);
}

TEST_F(PackCacheTest, packs_into_memory_without_a_cache) {
  const OpenedData opened = preprocess::open_data(data("a.mhd"), {.use_cache = false});
  EXPECT_TRUE(opened.was_packed);
  EXPECT_TRUE(opened.path.empty());
  EXPECT_EQ(largest(opened), 'a');
  EXPECT_FALSE(fs::exists(cache_folder()));
}

TEST_F(PackCacheTest, packs_into_memory_where_the_folder_cannot_be_used) {
  write_file(folder_ / "cache", "not a folder");
  const OpenedData opened = preprocess::open_data(data("a.mhd"));
  EXPECT_TRUE(opened.path.empty());
  EXPECT_NE(opened.not_kept, "");
  EXPECT_EQ(largest(opened), 'a');
}

TEST_F(PackCacheTest, does_not_use_a_folder_of_another_user) {
  fs::path foreign = "/usr";  // of root
  if (::geteuid() == 0) {
    foreign = folder_ / "foreign";
    fs::create_directories(foreign);
    ASSERT_EQ(::chown(foreign.c_str(), 4711, 4711), 0);
  }
  expect_error(ErrorCode::resource, "belongs to another user", [&] { PackCache cache(foreign); });
}

TEST_F(PackCacheTest, removes_what_was_not_used_for_the_longest_time) {
  write_volume("b.mhd", 'b');
  write_volume("c.mhd", 'c');
  const std::uint64_t bytes = preprocess::open_data(data("a.mhd")).file.file_bytes();
  const std::uint64_t room_for_two = 2 * bytes + bytes / 2;
  preprocess::open_data(data("b.mhd"), {.cache_limit_bytes = room_for_two});
  preprocess::open_data(data("a.mhd"), {.cache_limit_bytes = room_for_two});
  preprocess::open_data(data("c.mhd"), {.cache_limit_bytes = room_for_two});
  EXPECT_FALSE(preprocess::open_data(data("a.mhd")).was_packed);
  EXPECT_FALSE(preprocess::open_data(data("c.mhd")).was_packed);
  EXPECT_EQ(file_count(), 4U);
  EXPECT_TRUE(preprocess::open_data(data("b.mhd")).was_packed);
}

TEST_F(PackCacheTest, tells_apart_two_uses_within_a_tick_of_the_kernels_clock) {
  write_volume("b.mhd", 'b');
  const PackCache cache(PackCache::default_folder());
  for (int round = 0; round < 20; ++round)
    for (const char* name : {"a.mhd", "b.mhd"}) {
      preprocess::open_data(data(name));
      EXPECT_EQ(cache.entries().front().input, fs::canonical(data(name))) << "round " << round;
    }
}

TEST_F(PackCacheTest, uses_a_copy_that_is_larger_than_the_cache_without_keeping_it) {
  const OpenedData opened = preprocess::open_data(data("a.mhd"), {.cache_limit_bytes = 1});
  EXPECT_TRUE(opened.path.empty());
  EXPECT_EQ(opened.not_kept, "it is larger than the cache");
  EXPECT_EQ(largest(opened), 'a');
  EXPECT_EQ(file_count(), 0U);
}

TEST_F(PackCacheTest, counts_damaged_entries_as_none) {
  const fs::path copy = preprocess::open_data(data("a.mhd")).path;
  write_file(copy, "no packed file");
  EXPECT_TRUE(preprocess::open_data(data("a.mhd")).was_packed);
  for (const auto& entry : fs::directory_iterator(cache_folder()))
    if (entry.path().extension() == ".json") write_file(entry.path(), "{\"input\": 5}");
  EXPECT_TRUE(preprocess::open_data(data("a.mhd")).was_packed);
  EXPECT_FALSE(preprocess::open_data(data("a.mhd")).was_packed);
}

TEST_F(PackCacheTest, takes_no_file_outside_its_folder) {
  preprocess::open_data(data("a.mhd"));
  write_volume("b.mhd", 'b');
  const fs::path other = preprocess::open_data(data("b.mhd")).path;
  fs::copy_file(other, folder_ / "elsewhere.rho");
  for (const auto& entry : fs::directory_iterator(cache_folder()))
    if (entry.path().extension() == ".json") {
      std::string text = read_file(entry.path());
      const std::size_t at = text.find("\"packed\": \"") + std::strlen("\"packed\": \"");
      text.replace(at, text.find('"', at) - at, "../../elsewhere.rho");
      write_file(entry.path(), text);
    }
  EXPECT_EQ(largest(preprocess::open_data(data("a.mhd"))), 'a');
}

TEST_F(PackCacheTest, serves_several_at_once) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int round = 0; round < 5; ++round) EXPECT_EQ(largest(preprocess::open_data(data("a.mhd"))), 'a');
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(preprocess::open_data(data("a.mhd")).was_packed);
}

/// Each has packed before the first one keeps its copy.
TEST_F(PackCacheTest, keeps_one_copy_of_a_file_that_several_pack_at_once) {
  const PackCache cache(PackCache::default_folder());
  constexpr int count = 4;
  std::barrier all_packed(count);
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i)
    threads.emplace_back([&] {
      const PackCache::Copy copy = cache.add({.input = data("a.mhd"), .options = {}, .program = "1"},
                                             [&](const formats::Destination& destination) {
                                               const preprocess::PackReport report = pack_a(destination);
                                               all_packed.arrive_and_wait();
                                               return report;
                                             });
      EXPECT_EQ(largest(copy.file), 'a');
      EXPECT_TRUE(fs::exists(copy.path));
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(cache.entries().size(), 1U);
  EXPECT_EQ(file_count(), 2U) << "one copy and its record";
}

TEST_F(PackCacheTest, takes_the_copy_that_another_process_kept_meanwhile) {
  const PackCache cache(PackCache::default_folder());
  const PackCache::Key key{.input = data("a.mhd"), .options = {}, .program = "1"};
  for (const bool other_is_first : {true, false}) {
    std::optional<PackCache::Copy> other;
    const auto add_other = [&] {
      other = cache.add(key, [&](const auto& destination) { return pack_a(destination); });
    };
    const PackCache::Copy copy = cache.add(key, [&](const formats::Destination& destination) {
      if (other_is_first) add_other();
      const preprocess::PackReport report = pack_a(destination);
      if (!other_is_first) add_other();
      return report;
    });
    EXPECT_EQ(copy.path, other->path);
    EXPECT_EQ(copy.not_kept, "");
    EXPECT_TRUE(fs::exists(copy.path));
    EXPECT_EQ(largest(copy.file), 'a');
    EXPECT_EQ(file_count(), 2U);
    EXPECT_EQ(cache.clear().size(), 1U);
  }
}

TEST_F(PackCacheTest, does_not_keep_a_copy_that_another_process_removes) {
  const PackCache cache(PackCache::default_folder());
  const PackCache::Copy copy =
      cache.add({.input = data("a.mhd"), .options = {}, .program = "1"}, [&](const formats::Destination& destination) {
        EXPECT_EQ(cache.clear().size(), 0U) << "a file that is being written has no name";
        return pack_a(destination);
      });
  EXPECT_TRUE(fs::exists(copy.path));
  fs::remove(copy.path);
  EXPECT_EQ(cache.clear().size(), 0U) << "it was not removed here";
  EXPECT_EQ(file_count(), 0U);
}

TEST_F(PackCacheTest, lists_and_clears) {
  preprocess::open_data(data("a.mhd"));
  const PackCache cache(PackCache::default_folder());
  ASSERT_EQ(cache.entries().size(), 1U);
  EXPECT_EQ(cache.entries().front().input, fs::canonical(data("a.mhd")));
  const std::vector<PackCache::Entry> removed = cache.clear();
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed.front().input, fs::canonical(data("a.mhd")));
  EXPECT_TRUE(cache.entries().empty());
  EXPECT_TRUE(cache.clear().empty());
  EXPECT_EQ(file_count(), 0U);
}

TEST_F(PackCacheTest, leaves_refusals_of_packing_as_they_are) {
  write_file(data("bad.mhd"), "NDims = 0\n");
  EXPECT_THROW(preprocess::open_data(data("bad.mhd")), Error);
  EXPECT_EQ(file_count(), 0U);
}

}  // namespace
}  // namespace rhoray::tests
