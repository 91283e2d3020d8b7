#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "tests/tools/writing_commands.h"

namespace rhoray::tests {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// A file system of 8 MiB in memory, visible to this process and its children only.
class SmallDisk {
 public:
  SmallDisk() {
    is_there_ = ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                ::mount("small", path().c_str(), "tmpfs", 0, "size=8m") == 0;
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    if (is_there_) ::umount2(path().c_str(), MNT_DETACH);
  }

  bool is_there() const { return is_there_; }
  const fs::path& path() const { return folder_.path(); }

  /// Fills the disk to the last byte.
  void fill() const {
    const int file = ::open((path() / "filler").c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0600);
    const std::vector<char> page(4096);
    while (::write(file, page.data(), page.size()) > 0) {
    }
    ::close(file);
  }

 private:
  TemporaryFolder folder_;
  bool is_there_ = false;
};

/// Every name below a folder with its content.
std::map<std::string, std::string> contents_of(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    all[entry.path().lexically_relative(folder)] =
        entry.is_regular_file() ? read_file(entry.path()) : std::string("folder");
  return all;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

/// Expects one line with the fact, and at most one hint.
void expect_one_line(const RunResult& run) {
  const std::vector<std::string> lines = lines_of(run.err);
  ASSERT_FALSE(lines.empty());
  EXPECT_LE(lines.size(), 2U) << run.err;
  if (lines.size() == 2) {
    EXPECT_THAT(lines[1], testing::StartsWith("hint: ")) << run.err;
  }
}

TEST(FullDisk, every_command_ends_with_5_and_leaves_the_old_file_or_nothing) {
  const SmallDisk disk;
  if (!disk.is_there()) GTEST_SKIP() << "no right to mount a small file system";
  const Workbench bench;
  make_inputs(bench);
  for (const WritingCommand& command : writing_commands()) {
    SCOPED_TRACE(command.name);
    const fs::path out = disk.path() / "out";
    fs::create_directory(out);
    const RunResult good = run_program(command.line(out, false), bench.path());
    ASSERT_EQ(good.exit_code, 0) << good.err;
    for (const std::string& name : command.outputs) EXPECT_GT(fs::file_size(out / name), 0U) << name;

    for (const bool has_old : {true, false}) {
      SCOPED_TRACE(has_old ? "over good files" : "into an empty folder");
      if (!has_old) {
        fs::remove_all(out);
        fs::create_directory(out);
      }
      disk.fill();
      const auto before = contents_of(out);
      const RunResult run = run_program(command.line(out, has_old), bench.path());
      EXPECT_EQ(run.exit_code, 5) << run.err;
      expect_one_line(run);
      EXPECT_THAT(run.err, AllOf(HasSubstr(out.string()), HasSubstr("needed: "), HasSubstr("free: ")));
      EXPECT_EQ(contents_of(out), before) << "something was changed, or left behind";
    }
    fs::remove_all(out);
    fs::remove(disk.path() / "filler");
  }
}

// A user without the right to mount can have the same problem: a quota, or `ulimit -f`.
TEST(FullDisk, a_limit_of_file_size_is_met_the_same_way) {
  const Workbench bench;
  make_inputs(bench);
  const TemporaryFolder target;
  for (const WritingCommand& command : writing_commands()) {
    SCOPED_TRACE(command.name);
    const fs::path out = target / "out";
    fs::create_directory(out);
    const RunResult good = run_program(command.line(out, false), bench.path());
    ASSERT_EQ(good.exit_code, 0) << good.err;
    for (const bool has_old : {true, false}) {
      SCOPED_TRACE(has_old ? "over good files" : "into an empty folder");
      if (!has_old) {
        fs::remove_all(out);
        fs::create_directory(out);
      }
      const auto before = contents_of(out);
      // 1 KiB
      std::vector<std::string> words{"bash", "-c", "ulimit -f 1; exec \"$@\"", "bash"};
      const std::vector<std::string> line = command.line(out, has_old);
      words.insert(words.end(), line.begin(), line.end());
      const RunResult run = run_program(words, bench.path());
      EXPECT_EQ(run.exit_code, 5) << run.err;
      expect_one_line(run);
      EXPECT_EQ(contents_of(out), before) << "something was changed, or left behind";
    }
    fs::remove_all(out);
  }
}

/// A file that is held open: as long as it is, no other file gets its inode number.
class HeldFile {
 public:
  explicit HeldFile(const fs::path& path) : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error(path.string() + ": cannot be opened");
  }
  HeldFile(HeldFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  ~HeldFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  bool is_the_one_at(const fs::path& path) const {
    struct stat own {
    }, named{};
    return ::fstat(descriptor_, &own) == 0 && ::stat(path.c_str(), &named) == 0 && own.st_dev == named.st_dev &&
           own.st_ino == named.st_ino;
  }

 private:
  int descriptor_;
};

TEST(Replacing, every_command_keeps_links_and_permissions) {
  const Workbench bench;
  make_inputs(bench);
  const TemporaryFolder target;
  for (const WritingCommand& command : writing_commands()) {
    SCOPED_TRACE(command.name);
    const fs::path out = target / "out", store = target / "store";
    fs::create_directory(out);
    fs::create_directory(store);
    const RunResult good = run_program(command.line(out, false), bench.path());
    ASSERT_EQ(good.exit_code, 0) << good.err;
    for (const std::string& name : command.outputs) {
      const fs::path kept = store / fs::path(name).filename();
      fs::rename(out / name, kept);
      fs::create_symlink(kept, out / name);
      ASSERT_EQ(::chmod(kept.c_str(), 0640), 0);
    }
    std::map<std::string, HeldFile> old;
    for (const std::string& name : command.outputs) {
      old.emplace(name, HeldFile(out / name));
      ASSERT_TRUE(old.at(name).is_the_one_at(out / name));
    }
    const RunResult again = run_program(command.line(out, true), bench.path());
    EXPECT_EQ(again.exit_code, 0) << again.err;
    for (const std::string& name : command.outputs) {
      EXPECT_TRUE(fs::is_symlink(out / name)) << name;
      struct stat status {};
      ASSERT_EQ(::stat((out / name).c_str(), &status), 0) << name;
      EXPECT_EQ(status.st_mode & 07777, 0640U) << name;
      EXPECT_FALSE(old.at(name).is_the_one_at(out / name)) << name << " was not replaced as a whole";
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(store), {}), static_cast<std::ptrdiff_t>(command.outputs.size()));
    fs::remove_all(out);
    fs::remove_all(store);
  }
}

TEST(FullDisk, a_folder_that_cannot_be_written_ends_with_5) {
  const SmallDisk disk;
  if (!disk.is_there()) GTEST_SKIP() << "no right to mount a small file system";
  const Workbench bench;
  make_inputs(bench);
  ASSERT_EQ(::mount("small", disk.path().c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
  for (const WritingCommand& command : writing_commands()) {
    SCOPED_TRACE(command.name);
    const RunResult run = run_program(command.line(disk.path(), false), bench.path());
    EXPECT_EQ(run.exit_code, 5) << run.err;
    expect_one_line(run);
    EXPECT_THAT(run.err, HasSubstr(disk.path().string()));
  }
}

}  // namespace
}  // namespace rhoray::tests
