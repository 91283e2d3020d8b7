// Signals and standard output: how the program ends, what it leaves behind, and what it prints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/tools/started_program.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

const std::vector<std::string> endless_render{"render",         "box.rho",   "--size", "8000x8000", "--mode", "mip",
                                              "--no-hierarchy", "--threads", "1",      "-o",        "x.png"};
const std::vector<std::string> endless_bench{"bench", "pack", "box.vtu", "--repeat", "10000", "--scratch", "."};

/// Returns true once the folder contains a scratch folder.
bool has_scratch(const Workbench& bench) {
  for (const auto& entry : fs::directory_iterator(bench.path()))
    if (entry.path().filename().string().starts_with("rhoray-scratch")) return true;
  return false;
}

void wait_for_scratch(const Workbench& bench) {
  for (int i = 0; i < 2000 && !has_scratch(bench); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_TRUE(has_scratch(bench));
}

TEST(Signals, that_ask_for_an_end_are_told_apart_and_leave_nothing) {
  const Workbench bench;
  bench.make_box();
  const auto before = bench.contents();
  for (const auto& [signal, exit_code] : std::map<int, int>{{SIGINT, 130}, {SIGTERM, 143}, {SIGHUP, 129}}) {
    SCOPED_TRACE(signal);
    {
      StartedProgram program(bench.path(), endless_render);
      ASSERT_TRUE(program.maps("box.rho"));
      program.send(signal);
      EXPECT_EQ(program.wait(), exit_code);
      EXPECT_TRUE(program.exited()) << "killed, and not ended";
      EXPECT_EQ(program.said(), "\nrhoray: interrupted\n");
    }
    StartedProgram program(bench.path(), endless_bench);
    wait_for_scratch(bench);
    program.send(signal);
    EXPECT_EQ(program.wait(), exit_code);
    EXPECT_TRUE(program.exited());
    EXPECT_EQ(bench.contents(), before);
  }
}

TEST(Signals, of_a_terminal_that_hangs_up_stay_ignored_under_nohup) {
  const Workbench bench;
  bench.make_box();
  StartedProgram program(bench.path(), endless_render, {.ignored = {SIGHUP}});
  ASSERT_TRUE(program.maps("box.rho"));
  program.send(SIGHUP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  program.send(SIGTERM);
  EXPECT_EQ(program.wait(), 143);
}

class OutputPipe {
 public:
  OutputPipe() {
    if (::pipe(ends_) != 0) throw std::runtime_error("no pipe");
  }
  ~OutputPipe() {
    close_reader();
    ::close(ends_[1]);
  }
  int writer() const { return ends_[1]; }
  void close_reader() {
    if (ends_[0] >= 0) ::close(ends_[0]);
    ends_[0] = -1;
  }

 private:
  int ends_[2];
};

TEST(StandardOutput, whose_reader_has_gone_ends_the_program_silently_with_141) {
  const Workbench bench;
  bench.make_ball();
  const std::vector<std::vector<std::string>> commands{
      {"--help"}, {"--version"}, {"info", "ball.rho"}, {"info", "ball.rho", "--json"}, {"render", "--scene-schema"}};
  for (const std::vector<std::string>& words : commands)
    for (const bool ignored : {false, true}) {  // as for children of Python
      SCOPED_TRACE(testing::PrintToString(words));
      OutputPipe pipe;
      ::fcntl(pipe.writer(), F_SETFD, FD_CLOEXEC);
      pipe.close_reader();
      StartedProgram program(bench.path(), words,
                             {.out = pipe.writer(), .ignored = ignored ? std::vector{SIGPIPE} : std::vector<int>{}});
      EXPECT_EQ(program.wait(), 141);
      EXPECT_EQ(program.said(), "");
    }
}

TEST(StandardOutput, that_is_full_is_exit_code_5) {
  const Workbench bench;
  bench.make_ball();
  for (const char* words :
       {"--help", "--version", "info ball.rho", "info ball.rho --json", "verify ball.rho", "pack --help",
        "render --scene-schema", "render ball.rho --size 40x30 --stats -q -o x.png"}) {
    SCOPED_TRACE(words);
    const RunResult run = bench.shell(concat("rhoray ", words, " > /dev/full"));
    EXPECT_EQ(run.exit_code, 5);
    EXPECT_THAT(run.err, HasSubstr("rhoray: standard output: could not be written completely"));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  const RunResult damaged = bench.shell("head -c 9000 ball.rho > cut.rho; rhoray verify cut.rho > /dev/full");
  EXPECT_EQ(damaged.exit_code, 4) << "what was found counts more";
}

/// Without a guard, the packed file would be opened as descriptor 1, and the summary would go into
/// it.
TEST(StandardOutput, that_is_closed_is_nobody_elses) {
  const Workbench bench;
  bench.make_ball();
  const RunResult run = bench.shell("rhoray pack ball.raw --raw 24x24x24:uint8 --json -q -o again.rho 0<&- >&-");
  EXPECT_EQ(run.exit_code, 5) << run.err;
  EXPECT_EQ(bench.rhoray({"verify", "again.rho"}).exit_code, 0);
  EXPECT_EQ(bench.shell("rhoray pack ball.raw --raw 24x24x24:uint8 --force -q -o again.rho 0<&- >&- 2>&-").exit_code, 0)
      << "nothing was to be said";
}

TEST(FileSizes, beyond_the_limit_are_exit_code_5) {
  const Workbench bench;
  bench.make_ball_raw();
  const RunResult run = bench.shell("ulimit -f 8; rhoray pack ball.raw --raw 24x24x24:uint8 -q -o x.rho");
  EXPECT_EQ(run.exit_code, 5) << run.err;
  EXPECT_THAT(run.err, HasSubstr("File too large"));
  EXPECT_FALSE(fs::exists(bench / "x.rho"));
}

TEST(Help, names_the_limits_of_workers_and_the_exit_codes) {
  const RunResult help = Workbench().rhoray({"--help"});
  for (const char* words :
       {"8 GiB plus 1024 times", "90 %", "256 open", "60 s", "pipes and devices are refused", "143", "141"})
    EXPECT_THAT(help.out, HasSubstr(words));
}

}  // namespace
}  // namespace rhoray::tests
