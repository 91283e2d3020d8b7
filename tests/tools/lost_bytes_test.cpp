// Files that become shorter while they are read: one line, exit code 4, no result, no core file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "tests/tools/started_program.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// How often each command is disturbed. Reports state the longer run that the variable requests.
int round_count(int usual) {
  const char* asked = std::getenv("RHORAY_TRUNCATIONS");
  return asked == nullptr ? usual : std::atoi(asked);
}

int facts_in(const std::string& said) {
  int count = 0;
  for (std::size_t at = 0; at < said.size();) {
    const std::size_t end = std::min(said.find('\n', at), said.size());
    if (!said.substr(at, end - at).starts_with("hint: ")) ++count;
    at = end + 1;
  }
  return count;
}

struct Disturbed {
  int ended_before = 0, refused = 0;
};

/// Runs the command repeatedly, and truncates its input at another moment each time.
/// @param longest_ms  latest moment, after the input was mapped
Disturbed disturb(const Workbench& bench, const std::vector<std::string>& words, const char* input,
                  const std::string& output, int rounds, int longest_ms) {
  const std::string content = read_file(bench / input);
  std::mt19937 random(17);
  Disturbed count;
  for (int round = 0; round < rounds; ++round) {
    write_file(bench / input, content);
    fs::remove(bench / output);
    StartedProgram program(bench.path(), words);
    if (program.maps(input)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % static_cast<unsigned>(longest_ms)));
      fs::resize_file(bench / input, round % 3 == 0 ? 0 : random() % content.size());
    }
    const int exit_code = program.wait();
    EXPECT_TRUE(program.exited()) << exit_code << " in round " << round;
    if (exit_code == 0) {
      ++count.ended_before;
      continue;
    }
    ++count.refused;
    EXPECT_EQ(exit_code, 4) << program.said();
    EXPECT_EQ(facts_in(program.said()), 1) << program.said();
    EXPECT_THAT(program.said(), HasSubstr(input));
    EXPECT_FALSE(fs::exists(bench / output)) << "in round " << round;
  }
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator(bench.path()))
    if (const std::string name = entry.path().filename(); name.starts_with("core") || name.starts_with(".rhoray"))
      left.push_back(name);
  EXPECT_THAT(left, testing::IsEmpty());
  return count;
}

TEST(LostBytes, of_a_packed_file_end_the_picture_with_one_line) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  // Each takes some tenths of a second; threads and methods read in different orders.
  const std::vector<std::string> common{"-o", "x.png", "-q", "--no-hierarchy"};
  std::vector<std::pair<const char*, std::vector<std::string>>> commands{
      {"ball.rho", {"render", "ball.rho", "--mode", "mip", "--threads", "1", "--size", "500x500"}},
      {"ball.rho",
       {"render", "ball.rho", "--iso", "60", "--accuracy", "certified", "--no-verify", "--size", "400x400"}},
      {"box.rho", {"render", "box.rho", "--iso", "0.5", "--accuracy", "exact", "--no-verify", "--size", "120x120"}},
      {"box.rho", {"render", "box.rho", "--mode", "mip", "--no-verify", "--size", "400x400"}}};
  Disturbed all;
  for (auto& [input, words] : commands) {
    words.insert(words.end(), common.begin(), common.end());
    SCOPED_TRACE(testing::PrintToString(words));
    const Disturbed count = disturb(bench, words, input, "x.png", round_count(3), 150);
    all.refused += count.refused;
    all.ended_before += count.ended_before;
  }
  EXPECT_GT(all.refused, all.ended_before) << "the files were made shorter too late";
}

TEST(LostBytes, of_a_foreign_file_leave_no_packed_file) {
  const Workbench bench;
  write_file(bench / "large.raw", std::string(std::size_t{1} << 26, '\3'));
  const Disturbed count = disturb(bench, {"pack", "large.raw", "--raw", "256x512x512:uint8", "-o", "x.rho", "-q"},
                                  "large.raw", "x.rho", round_count(4), 60);
  EXPECT_GT(count.refused, 0);
}

TEST(LostBytes, of_a_packed_file_leave_no_exported_file) {
  const Workbench bench;
  write_file(bench / "large.raw", std::string(std::size_t{1} << 25, '\3'));
  ASSERT_EQ(bench.rhoray({"pack", "large.raw", "--raw", "256x256x512:uint8", "-o", "large.rho", "-q"}).exit_code, 0);
  const Disturbed count =
      disturb(bench, {"export", "large.rho", "-o", "x.npy", "-q"}, "large.rho", "x.npy", round_count(4), 30);
  EXPECT_GT(count.refused, 0);
}

}  // namespace
}  // namespace rhoray::tests
