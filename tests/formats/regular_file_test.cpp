#include "formats/base/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray {
namespace {

using tests::expect_error;

/// Opening a pipe without a writer would block for ever.
TEST(RegularFile, refuses_what_is_no_file_at_once) {
  const tests::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink(folder / "pipe", folder / "link");
  expect_error(ErrorCode::unreadable, "pipe: found a pipe; expected a file",
               [&] { open_regular_file(folder / "pipe"); });
  expect_error(ErrorCode::unreadable, "link: found a pipe", [&] { open_regular_file(folder / "link"); });
  expect_error(ErrorCode::unreadable, "found a folder", [&] { open_regular_file(folder.path()); });
  expect_error(ErrorCode::unreadable, "/dev/zero: found a device", [&] { open_regular_file("/dev/zero"); });
  expect_error(ErrorCode::unreadable, "none: No such file", [&] { open_regular_file(folder / "none"); });
  expect_error(ErrorCode::unreadable, "found a pipe", [&] { require_regular_file(folder / "pipe"); });
}

TEST(RegularFile, opens_a_file_that_is_closed_on_exec) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "a", "content");
  std::filesystem::create_symlink("a", folder / "link");
  const int descriptor = open_regular_file(folder / "link");
  char bytes[16];
  EXPECT_EQ(::read(descriptor, bytes, sizeof bytes), 7);
  EXPECT_EQ(::fcntl(descriptor, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
  ::close(descriptor);
}

TEST(RegularFile, gives_its_first_bytes_and_none_where_there_are_none) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "a", "content");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(first_bytes(folder / "a", 3), "con");
  EXPECT_EQ(first_bytes(folder / "a", 100), "content");
  EXPECT_EQ(first_bytes(folder / "pipe", 3), "");
  EXPECT_EQ(first_bytes("/dev/zero", 3), "");
  EXPECT_EQ(first_bytes(folder / "none", 3), "");
  EXPECT_EQ(first_bytes(folder.path(), 3), "");
}

TEST(RegularFile, takes_memory_for_what_is_there_and_not_for_what_is_asked) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "a", "content");
  EXPECT_LT(first_bytes(folder / "a", std::size_t{64} << 20).capacity(), std::size_t{1} << 16);
  const std::string long_text(100'000, 'x');
  tests::write_file(folder / "long", long_text);
  EXPECT_EQ(first_bytes(folder / "long", std::size_t{64} << 20), long_text);
  EXPECT_EQ(first_bytes(folder / "long", 99'999), long_text.substr(1));
}

}  // namespace
}  // namespace rhoray
