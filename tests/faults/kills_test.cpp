#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "tests/tools/started_program.h"
#include "tests/tools/writing_commands.h"

/// Programs that are killed while they write.
namespace rhoray::tests {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

bool runs_all() {
  const char* const all = std::getenv("RHORAY_ALL_FAULTS");
  return all != nullptr && *all != '\0';
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    names.insert(entry.path().lexically_relative(folder).string());
  return names;
}

const std::string old_content = "what was there before";

/// Creates old files with the names of a command's outputs.
void make_old(const WritingCommand& command, const fs::path& out) {
  for (const std::string& output : command.outputs) {
    fs::create_directories((out / output).parent_path());
    write_file(out / output, old_content);
  }
}

/// The last two bytes, with 0 for each digit: a table may end in a time.
std::string end_of(const std::string& content) {
  std::string end = content.substr(content.size() - std::min<std::size_t>(2, content.size()));
  for (char& byte : end)
    if (byte >= '0' && byte <= '9') byte = '0';
  return end;
}

/// Recognizes complete new files. Where two runs write the same bytes, compares all bytes.
/// Otherwise compares the ends, which a file that ends too early has only by chance.
class WholeFiles {
 public:
  WholeFiles(const WritingCommand& command, const fs::path& out) : command_(command), out_(out) {
    for (const std::string& output : command.outputs) contents_[output] = read_file(out / output);
  }
  void compare_with_second_run() {
    for (auto& [output, content] : contents_)
      if (read_file(out_ / output) != content) varying_.insert(output);
  }

  void expect_old_or_new() const {
    for (const std::string& output : command_.outputs) {
      const std::string now = read_file(out_ / output), &whole = contents_.at(output);
      if (now == old_content) continue;
      if (varying_.contains(output))
        EXPECT_EQ(end_of(now), end_of(whole)) << output;
      else
        EXPECT_TRUE(now == whole) << output << " has " << now.size() << " bytes, whole it has " << whole.size();
    }
  }

 private:
  const WritingCommand& command_;
  fs::path out_;
  std::map<std::string, std::string> contents_;
  std::set<std::string> varying_;
};

// At any moment each file is the complete old one or the complete new one, and the next run removes
// what was left.
TEST(Kills, leave_whole_files_and_what_else_is_left_the_next_run_removes) {
  const Workbench bench;
  make_inputs(bench);
  std::mt19937_64 random(20261123);
  int killed_at_work = 0;
  for (const WritingCommand& command : writing_commands()) {
    const std::string name = command.name;
    const bool is_short = name == "render_png" || name == "export_vtu" || name == "pack_mesh" || name == "resample_vdb";
    if (!is_short && !runs_all()) continue;
    SCOPED_TRACE(name);
    const TemporaryFolder target;
    const fs::path out = target / "out";
    fs::create_directory(out);
    const auto run_whole = [&](bool replaces) {
      const RunResult done = run_program(command.line(out, replaces), bench.path());
      EXPECT_EQ(done.exit_code, 0) << done.err;
    };
    run_whole(false);
    WholeFiles whole(command, out);
    const auto begin = Clock::now();
    run_whole(true);
    const auto takes = Clock::now() - begin;
    whole.compare_with_second_run();
    const std::set<std::string> names = names_in(out);

    const int kills = runs_all() ? 300 : 10;
    int at_work = 0;
    for (int kill = 0; kill < kills; ++kill) {
      make_old(command, out);
      StartedProgram program(bench.path(), command.line(out, true));
      std::this_thread::sleep_for(takes * std::uniform_real_distribution(0.0, 1.0)(random));
      program.send(SIGKILL);
      const int code = program.wait();
      EXPECT_TRUE(code == 128 + SIGKILL || code == 0) << code << ": " << program.said();
      at_work += code == 0 ? 0 : 1;
      whole.expect_old_or_new();
    }
    std::size_t left = 0;
    for (const std::string& file : names_in(out)) left += names.contains(file) ? 0 : 1;
    run_whole(true);
    EXPECT_EQ(names_in(out), names) << "the next run leaves what killed ones left";
    killed_at_work += at_work;
    std::cout << name << ": " << kills << " kills, " << at_work << " at work, " << left
              << " names left behind for the next run" << std::endl;
  }
  EXPECT_GT(killed_at_work, 0) << "all had finished before";
}

}  // namespace
}  // namespace rhoray::tests
