#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>

#include "formats/base/text.h"
#include "tests/tools/writing_commands.h"

namespace rhoray::tests {
namespace {

namespace fs = std::filesystem;

bool runs_all() {
  const char* const all = std::getenv("RHORAY_ALL_FAULTS");
  return all != nullptr && *all != '\0';
}

/// Every name below a folder with its content.
using Contents = std::map<std::string, std::string>;
Contents contents_of(const fs::path& folder) {
  Contents all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    all[entry.path().lexically_relative(folder)] =
        entry.is_regular_file() ? read_file(entry.path()) : std::string("folder");
  return all;
}

struct Kind {
  const char* call;
  int error;
};
constexpr Kind kinds[] = {{"write", ENOSPC}, {"fsync", EIO},   {"rename", EIO},
                          {"close", EIO},    {"mmap", ENOMEM}, {"fork", EAGAIN}};

/// A command with one call that fails.
class FaultRun {
 public:
  FaultRun(const WritingCommand& command, const fs::path& folder, const fs::path& out)
      : command_(command), folder_(folder), out_(out), counter_(out.parent_path() / "counter") {}

  RunResult run(const Kind& kind, std::uint64_t at) const {
    write_file(counter_, std::string(8, '\0'));
    std::vector<std::string> words{"env",
                                   "ASAN_OPTIONS=verify_asan_link_order=0",
                                   concat("LD_PRELOAD=", RHORAY_FAILING_CALLS),
                                   concat("RHORAY_FAIL_CALL=", kind.call),
                                   concat("RHORAY_FAIL_AT=", at),
                                   concat("RHORAY_FAIL_ERRNO=", kind.error),
                                   concat("RHORAY_FAIL_COUNT=", counter_.string())};
    const std::vector<std::string> line = command_.line(out_, true);
    words.insert(words.end(), line.begin(), line.end());
    return run_program(words, folder_);
  }

  /// Number of calls of this kind in the last run.
  std::uint64_t count() const {
    const std::string bytes = read_file(counter_);
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }

 private:
  const WritingCommand& command_;
  fs::path folder_, out_, counter_;
};

/// No name was lost, and no temporary one was left.
void expect_same_names(const Contents& before, const Contents& after) {
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [file, content] : after) EXPECT_TRUE(before.contains(file)) << file;
}

void expect_new_outputs(const WritingCommand& command, const Contents& before, const Contents& after) {
  ASSERT_NO_FATAL_FAILURE(expect_same_names(before, after));
  for (const std::string& output : command.outputs)
    EXPECT_NE(after.at(output), before.at(output)) << output << " is older than the files beside it";
}

// Whatever call fails, one of two outcomes is right. Either the command ends with 5 and all is as
// before (a command that writes interim results may have replaced all of them), or the failure did no
// harm and the files are complete.
TEST(FailingCalls, each_ends_with_5_and_the_old_files_or_does_no_harm) {
  const Workbench bench;
  make_inputs(bench);
  std::map<std::string, int> runs, refusals;
  for (const WritingCommand& command : writing_commands()) {
    const std::string name = command.name;
    const bool is_short =
        name == "render_png" || name == "export_vdb" || name == "export_vtu" || name == "recipes_nrrd";
    if (!is_short && !runs_all()) continue;
    const TemporaryFolder target;
    const fs::path out = target / "out";
    fs::create_directory(out);
    const RunResult good = run_program(command.line(out, false), bench.path());
    ASSERT_EQ(good.exit_code, 0) << name << ": " << good.err;
    for (const Kind& kind : kinds) {
      const FaultRun fault(command, bench.path(), out);
      ASSERT_EQ(fault.run(kind, 0).exit_code, 0) << name;
      const std::uint64_t calls = fault.count();
      const std::uint64_t step = runs_all() ? 1 : std::max<std::uint64_t>(1, calls / 4);
      const int runs_before = runs[kind.call], refusals_before = refusals[kind.call];
      for (std::uint64_t at = 1; at <= calls; at += step) {
        SCOPED_TRACE(concat(name, ", ", kind.call, " ", at, " of ", calls));
        const auto before = contents_of(out);
        const RunResult run = fault.run(kind, at);
        ++runs[kind.call];
        const auto after = contents_of(out);
        if (run.exit_code == 0) {
          expect_same_names(before, after);
          continue;
        }
        ++refusals[kind.call];
        EXPECT_EQ(run.exit_code, 5) << run.err;
        if (command.writes_interim_results && after != before)
          expect_new_outputs(command, before, after);
        else
          EXPECT_EQ(after, before) << "something was changed, or left behind";
      }
      std::cout << name << ", " << kind.call << ": " << calls << " calls, " << runs[kind.call] - runs_before
                << " runs, " << refusals[kind.call] - refusals_before << " refusals" << std::endl;
    }
  }
  for (const Kind& kind : kinds) {
    EXPECT_GT(runs[kind.call], 0) << kind.call << ": no such call was met";
    std::printf("%s: %d runs, %d refusals\n", kind.call, runs[kind.call], refusals[kind.call]);
  }
  for (const char* const call : {"write", "fsync", "rename", "mmap", "fork"}) EXPECT_GT(refusals[call], 0) << call;
}

}  // namespace
}  // namespace rhoray::tests
