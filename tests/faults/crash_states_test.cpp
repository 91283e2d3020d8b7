#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <iostream>
#include <map>
#include <random>
#include <set>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "formats/packed_file.h"
#include "tests/faults/crash_model.h"
#include "tests/support/memory_file.h"
#include "tests/tools/workbench.h"

/// Machines that stop while a packed file is written, and what the disk can hold afterwards.
namespace rhoray::tests {
namespace {

namespace fs = std::filesystem;

const std::string old_content = "what was there before";

FolderContents contents_of(const fs::path& folder) {
  FolderContents contents;
  for (const auto& [name, file] : read_folder(folder)) contents[name] = file.content;
  return contents;
}

/// `pack` in an empty folder, or with --force in a folder that has an old file of the same name.
struct Scenario {
  std::string name;
  std::vector<std::string> words;  ///< words of the command, which runs in the folder
  bool replaces = false;
  const char* missing = "";  ///< what the folder's file system lacks: RHORAY_RECORD_MISSING
};

std::vector<Scenario> scenarios(const Workbench& bench) {
  const std::pair<const char*, std::vector<std::string>> inputs[] = {
      {"mesh", {bench / "box.vtu"}}, {"grid", {bench / "ball.raw", "--raw", "24x24x24:uint8"}}};
  std::vector<Scenario> all;
  for (const char* const missing : {"", "anonymous", "anonymous, flags"})
    for (const bool replaces : {false, true})
      for (const auto& [kind, input] : inputs) {
        std::vector<std::string> words{RHORAY_PROGRAM, "pack", "-o", "a.rho", "-q"};
        words.insert(words.end(), input.begin(), input.end());
        if (replaces) words.push_back("--force");
        const std::string name =
            concat(kind, replaces ? " over an old file" : "", *missing == '\0' ? "" : ", without: ", missing);
        all.push_back({name, words, replaces, missing});
      }
  return all;
}

/// A run of a scenario, with all changes that it made in its folder.
class Recording {
 public:
  explicit Recording(const Scenario& scenario) : scenario_(scenario) {
    const TemporaryFolder target;
    const fs::path out = target / "out", record = target / "record";
    fs::create_directory(out);
    if (scenario.replaces) write_file(out / "a.rho", old_content);
    before_ = read_folder(out);
    write_file(record, "");
    std::vector<std::string> words{"env",
                                   "ASAN_OPTIONS=verify_asan_link_order=0",
                                   concat("LD_PRELOAD=", RHORAY_RECORDED_CALLS),
                                   concat("RHORAY_RECORD_FOLDER=", fs::canonical(out).string()),
                                   concat("RHORAY_RECORD_FILE=", record.string()),
                                   concat("RHORAY_RECORD_MISSING=", scenario.missing)};
    words.insert(words.end(), scenario.words.begin(), scenario.words.end());
    const RunResult run = run_program(words, out);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    calls_ = read_calls(record);
    after_ = contents_of(out);
  }

  /// The recording as if no call of this kind had been made.
  Recording without(CallKind kind) const {
    Recording less = *this;
    EXPECT_GT(std::erase_if(less.calls_, [&](const RecordedCall& call) { return call.header.kind == kind; }), 0u);
    return less;
  }

  std::size_t call_count() const { return calls_.size(); }
  CrashModel model() const { return {before_, calls_}; }
  const FolderContents& after() const { return after_; }

  /// Describes what is wrong with a state that a crash left; empty when nothing is wrong.
  /// @param has_ended  whether the crash came after the command had ended
  std::string fault_of(const FolderContents& state, bool has_ended) const;

  /// Runs the command again in a folder of this state. Expects that only its output file is left.
  void expect_next_run_clears(const FolderContents& state) const;

 private:
  Scenario scenario_;
  NumberedFolder before_;
  std::vector<RecordedCall> calls_;
  FolderContents after_;
};

bool is_refused(const std::string& content) {
  const MemoryFile file(content);
  try {
    return !formats::PackedFile::from_descriptor(file.descriptor(), "left behind").damaged_blocks(1).empty();
  } catch (const Error&) {
    return true;
  }
}

std::string Recording::fault_of(const FolderContents& state, bool has_ended) const {
  const std::string& whole = after_.at("a.rho");
  const auto found = state.find("a.rho");
  const bool is_whole = found != state.end() && found->second == whole;
  if (has_ended && !is_whole) return "the command had ended and its file is not there";
  if (found == state.end() && scenario_.replaces) return "the old file is gone";
  if (found != state.end() && !is_whole && !(scenario_.replaces && found->second == old_content))
    return "the file is neither the old one nor the whole new one";
  for (const auto& [name, content] : state) {
    if (name == "a.rho") continue;
    if (!name.starts_with(".rhoray-") || !name.ends_with(".partial")) return concat("a file was left: ", name);
    if (content != whole && !is_refused(content)) return concat(name, " is not whole, and the reader takes it");
  }
  return {};
}

void Recording::expect_next_run_clears(const FolderContents& state) const {
  const TemporaryFolder out;
  for (const auto& [name, content] : state) write_file(out / name, content);
  std::vector<std::string> words = scenario_.words;
  if (!scenario_.replaces && state.contains("a.rho")) words.push_back("--force");
  const RunResult run = run_program(words, out.path());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contents_of(out.path()) == after_) << "another file, or more than one";
}

/// Draws at least the given number of states, equally many for each moment between two calls, and
/// calls act() for new states. Returns the number of distinct states.
std::size_t draw_states(const Recording& recording, std::size_t at_least,
                        const std::function<void(const FolderContents& state, bool has_ended)>& act) {
  std::mt19937_64 random(20261123);
  const CrashModel model = recording.model();
  const std::size_t moments = recording.call_count() + 1;
  std::set<FolderContents> seen;
  for (std::size_t ended = 0; ended < moments; ++ended)
    for (std::size_t i = 0; i < (at_least + moments - 1) / moments; ++i) {
      const auto [state, is_new] = seen.insert(model.draw(ended, random));
      const bool has_ended = ended == recording.call_count();
      if (is_new || has_ended) act(*state, has_ended);
    }
  return seen.size();
}

class CrashStates : public testing::Test {
 protected:
  CrashStates() {
    bench_.make_ball_raw();
    bench_.make_box_vtu();
  }

  Workbench bench_;
};

// 1,000 and more combinations of order and subset in which written data reach the disk.
TEST_F(CrashStates, have_the_old_file_or_the_whole_new_one) {
  std::size_t distinct = 0;
  for (const Scenario& scenario : scenarios(bench_)) {
    SCOPED_TRACE(scenario.name);
    const Recording recording(scenario);
    ASSERT_TRUE(recording.model().outcome() == recording.after()) << "something is written by calls that are not seen";
    std::set<std::size_t> left;
    std::map<std::string, int> faults;
    const std::size_t states = draw_states(recording, 6000, [&](const FolderContents& state, bool has_ended) {
      const std::string fault = recording.fault_of(state, has_ended);
      if (!fault.empty()) ++faults[fault];
      // Runs take time: make one for each number of files left behind.
      if (left.insert(state.size()).second) recording.expect_next_run_clears(state);
    });
    EXPECT_THAT(faults, testing::IsEmpty());
    std::cout << scenario.name << ": " << recording.call_count() << " calls, " << states << " states" << std::endl;
    distinct += states;
  }
  EXPECT_GE(distinct, 1000u);
}

// The drawn states reveal a writer that omits a flush.
TEST_F(CrashStates, would_break_the_promise_if_the_file_or_its_folder_were_not_flushed) {
  const std::pair<CallKind, const char*> flushes[] = {
      {CallKind::flush_file, "the file is neither the old one nor the whole new one"},
      {CallKind::flush_folder, "the command had ended and its file is not there"}};
  for (const Scenario& scenario : scenarios(bench_)) {
    const Recording recording(scenario);
    for (const auto& [flush, expected] : flushes) {
      SCOPED_TRACE(scenario.name);
      const Recording less = recording.without(flush);
      std::set<std::string> faults;
      draw_states(less, 1000,
                  [&](const FolderContents& state, bool has_ended) { faults.insert(less.fault_of(state, has_ended)); });
      EXPECT_THAT(faults, testing::Contains(expected));
    }
  }
}

}  // namespace
}  // namespace rhoray::tests
