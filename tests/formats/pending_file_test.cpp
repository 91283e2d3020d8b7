#include "formats/base/pending_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <functional>
#include <set>

#include "formats/base/text.h"
#include "tests/formats/failing_calls.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::expect_error;
using tests::read_file;
using tests::TemporaryFolder;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

/// Runs act() in a child process that ends without destructors, and returns its exit status; 99 for
/// an exception.
int in_child(const std::function<int()>& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    int code = 99;
    try {
      code = act();
    } catch (...) {
    }
    ::_exit(code);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void write(const fs::path& path, std::string_view text, PendingFile::Options options) {
  PendingFile file(path, options);
  file.reserve(text.size());
  file.append(text.substr(0, text.size() / 2));
  file.append(text.substr(text.size() / 2));
  file.publish();
}

struct stat status_of(const fs::path& path) {
  struct stat status {};
  EXPECT_EQ(::lstat(path.c_str(), &status), 0);
  return status;
}

TEST(PendingFile, what_is_replaced_hands_on_its_permissions_owner_and_group) {
  for (const bool anonymous : {true, false}) {
    const TemporaryFolder folder;
    tests::write_file(folder / "a", "old");
    ASSERT_EQ(::chmod((folder / "a").c_str(), 0604), 0);
    const bool may_give_away = ::geteuid() == 0;
    if (may_give_away) {
      ASSERT_EQ(::chown((folder / "a").c_str(), 1234, 4321), 0);
    }
    write(folder / "a", "new", {.replace_existing = true, .anonymous = anonymous});
    EXPECT_EQ(read_file(folder / "a"), "new");
    const struct stat status = status_of(folder / "a");
    EXPECT_EQ(status.st_mode & 07777, 0604U);
    if (may_give_away) {
      EXPECT_EQ(status.st_uid, 1234U);
      EXPECT_EQ(status.st_gid, 4321U);
    }
  }
}

// If the user cannot keep the group, the new group must not gain access to what only the old group
// could read.
TEST(PendingFile, another_group_gets_only_what_all_others_have) {
  if (::geteuid() != 0) GTEST_SKIP() << "no right to become another user";
  const TemporaryFolder folder;
  ASSERT_EQ(::chmod(folder.path().c_str(), 0777), 0);
  tests::write_file(folder / "a", "old");
  ASSERT_EQ(::chown((folder / "a").c_str(), 1234, 4321), 0);
  ASSERT_EQ(::chmod((folder / "a").c_str(), 0664), 0);
  const int code = in_child([&] {
    if (::setgid(2000) != 0 || ::setuid(2000) != 0) return 1;
    write(folder / "a", "new", {.replace_existing = true});
    return 0;
  });
  ASSERT_EQ(code, 0);
  const struct stat status = status_of(folder / "a");
  EXPECT_EQ(status.st_uid, 2000U);
  EXPECT_EQ(status.st_mode & 07777, 0644U);
}

TEST(PendingFile, a_temporary_name_is_as_private_as_what_it_replaces_while_it_is_written) {
  const TemporaryFolder folder;
  tests::write_file(folder / "a", "old");
  ASSERT_EQ(::chmod((folder / "a").c_str(), 0600), 0);
  const PendingFile file(folder / "a", {.replace_existing = true, .anonymous = false});
  EXPECT_EQ(status_of(file.open_name()).st_mode & 07777, 0600U);
}

TEST(PendingFile, a_link_stays_a_link_also_with_a_temporary_name) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "store");
  tests::write_file(folder / "store/real", "old");
  fs::create_symlink("store/real", folder / "link");
  write(folder / "link", "new", {.replace_existing = true, .anonymous = false});
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_file(folder / "store/real"), "new");
  EXPECT_THAT(names_in(folder / "store"), ElementsAre("real"));
}

// Every system call for writing fails once: afterwards an old file exists again, and a new file
// does not exist.
TEST(PendingFile, whichever_call_fails_the_old_file_is_there_and_nothing_else) {
  std::set<std::string> failed;
  for (const bool anonymous : {true, false})
    for (const bool has_old : {true, false})
      for (const int error : {EIO, ENOSPC}) {
        int position = 1;
        for (bool was_met = true; was_met; ++position) {
          const TemporaryFolder folder;
          if (has_old) tests::write_file(folder / "a", "old");
          const PendingFile::Options options{.replace_existing = has_old, .anonymous = anonymous};
          bool was_refused = false;
          {
            const tests::FailingCall call(position, error);
            try {
              write(folder / "a", "whole", options);
            } catch (const Error& refusal) {
              was_refused = true;
              EXPECT_EQ(refusal.code(), ErrorCode::resource) << refusal.what();
              EXPECT_THAT(refusal.what(), HasSubstr((folder / "a").string()));
            }
            was_met = !call.failed().empty();
            if (was_met) failed.insert(call.failed());
          }
          SCOPED_TRACE(concat("call ", position, ", anonymous ", anonymous, ", old ", has_old, ", error ", error));
          const std::vector<std::string> names = names_in(folder.path());
          if (was_refused && !has_old) {
            EXPECT_THAT(names, IsEmpty());
          } else {
            ASSERT_THAT(names, ElementsAre("a"));
            EXPECT_EQ(read_file(folder / "a"), was_refused ? "old" : "whole");
          }
        }
        EXPECT_GT(position, 6) << "fewer calls than there must be: is the C library's function taken?";
      }
  EXPECT_THAT(failed, testing::IsSupersetOf({"pwrite", "fallocate", "fsync", "close", "fcntl", "linkat", "renameat2"}));
}

TEST(PendingFiles, appear_together_or_not_at_all) {
  std::set<std::string> failed;
  int position = 1;
  for (bool was_met = true; was_met; ++position) {
    const TemporaryFolder folder;
    tests::write_file(folder / "b", "old b");
    bool was_refused = false;
    {
      const tests::FailingCall call(position, EIO);
      try {
        PendingFiles files(true);
        for (const char* const name : {"a", "b", "c"}) files.add(folder / name, concat("new ", name));
        files.publish();
      } catch (const Error& refusal) {
        was_refused = true;
        EXPECT_EQ(refusal.code(), ErrorCode::resource) << refusal.what();
      }
      was_met = !call.failed().empty();
      failed.insert(call.failed());
    }
    if (was_refused) {
      ASSERT_THAT(names_in(folder.path()), ElementsAre("b")) << position;
      EXPECT_EQ(read_file(folder / "b"), "old b");
    } else {
      ASSERT_THAT(names_in(folder.path()), ElementsAre("a", "b", "c")) << position;
      EXPECT_EQ(read_file(folder / "b"), "new b");
    }
  }
  EXPECT_GT(position, 20);
  EXPECT_THAT(failed, testing::IsSupersetOf({"fsync", "linkat", "renameat2"}));
}

TEST(PendingFiles, one_that_came_meanwhile_keeps_the_others_away) {
  const TemporaryFolder folder;
  PendingFiles files(false);
  files.add(folder / "a", "new a");
  files.add(folder / "b", "new b");
  tests::write_file(folder / "b", "of another program");
  expect_error(ErrorCode::usage, "already exists", [&] { files.publish(); });
  EXPECT_THAT(names_in(folder.path()), ElementsAre("b"));
  EXPECT_EQ(read_file(folder / "b"), "of another program");
}

TEST(PendingFile, a_full_disk_is_told_with_the_bytes_that_are_needed_and_free) {
  const TemporaryFolder folder;
  constexpr int skipped = 77;
  const int code = in_child([&] {
    const bool alone = ::unshare(CLONE_NEWNS) == 0 || ::unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0;
    if (!alone || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount("small", folder.path().c_str(), "tmpfs", 0, "size=256k") != 0)
      return skipped;
    tests::write_file(folder / "a", "old");
    for (const bool reserves : {true, false}) try {
        PendingFile file(folder / "a", {.replace_existing = true});
        if (reserves) file.reserve(1'000'000);
        const std::vector<std::byte> bytes(1'000'000);
        file.append(bytes);
        return 1;
      } catch (const Error& error) {
        const std::string said = error.what();
        if (error.code() != ErrorCode::resource ||
            said.find("needed: 1000000 bytes, free: 258048 bytes") == said.npos) {
          std::fprintf(stderr, "%s\n", said.c_str());
          return 2;
        }
      }
    return read_file(folder / "a") == "old" && names_in(folder.path()).size() == 1 ? 0 : 3;
  });
  if (code == skipped) GTEST_SKIP() << "no right to mount a small file system";
  EXPECT_EQ(code, 0);
}

TEST(PendingFile, a_folder_that_cannot_be_written_is_out_of_resources_and_a_missing_one_wrong_usage) {
  expect_error(ErrorCode::usage, "No such file", [] { PendingFile("/nowhere/at/all", {}); });
  if (::geteuid() != 0) return;
  const TemporaryFolder folder;  // belongs to root and is closed to others
  EXPECT_EQ(in_child([&] {
              if (::chmod(folder.path().c_str(), 0755) != 0 || ::setuid(2000) != 0) return 1;
              try {
                PendingFile(folder / "a", {});
                return 2;
              } catch (const Error& error) {
                return error.code() == ErrorCode::resource ? 0 : 3;
              }
            }),
            0);
}

// ---- temporary names of killed processes --------------------------------------------------------

/// Kills a process while it has a temporary name.
void leave_stale_name(const fs::path& target) {
  ASSERT_EQ(in_child([&] {
              PendingFile file(target, {.anonymous = false});
              file.append("half");
              ::kill(::getpid(), SIGKILL);
              return 0;
            }),
            128 + SIGKILL);
}

TEST(PendingFile, the_next_process_removes_what_a_killed_one_left) {
  const TemporaryFolder folder;
  leave_stale_name(folder / "a");
  leave_stale_name(folder / "b");
  EXPECT_THAT(names_in(folder.path()), ElementsAre(HasSubstr(".partial")))
      << "the second process should have removed what the first left";
  tests::write_file(folder / ".rhoray-of-mine", "");
  EXPECT_EQ(in_child([&] {
              write(folder / "c", "whole", {});
              return 0;
            }),
            0);
  EXPECT_THAT(names_in(folder.path()), ElementsAre(".rhoray-of-mine", "c"));
}

TEST(PendingFile, the_temporary_name_of_a_living_process_is_left_alone) {
  const TemporaryFolder folder;
  std::array<int, 2> ready{}, go{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  ASSERT_EQ(::pipe(go.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    char letter = 0;
    try {
      PendingFile file(folder / "a", {.anonymous = false});
      file.append("of the child");
      if (::write(ready[1], "x", 1) != 1 || ::read(go[0], &letter, 1) != 1) ::_exit(1);
      file.publish();
      ::_exit(0);
    } catch (...) {
      ::_exit(2);
    }
  }
  char letter = 0;
  ASSERT_EQ(::read(ready[0], &letter, 1), 1);
  write(folder / "b", "of the parent", {});  // the parent's first access to the folder
  EXPECT_THAT(names_in(folder.path()), ElementsAre(HasSubstr(".partial"), "b"));
  ASSERT_EQ(::write(go[1], "x", 1), 1);
  int status = 0;
  ::waitpid(child, &status, 0);
  for (const int end : {ready[0], ready[1], go[0], go[1]}) ::close(end);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(read_file(folder / "a"), "of the child");
}

TEST(PendingFile, an_end_without_destructors_can_remove_temporary_names) {
  const TemporaryFolder folder;
  EXPECT_EQ(in_child([&] {
              PendingFile a(folder / "a", {.anonymous = false}), b(folder / "b", {.anonymous = false});
              a.append("half");
              end_pending_files();
              ::_exit(0);
              return 0;
            }),
            0);
  EXPECT_THAT(names_in(folder.path()), IsEmpty());
}

}  // namespace
}  // namespace rhoray
