#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The scene that `rhoray render ball.rho WORDS` resolves, and its messages.
struct Asked {
  nlohmann::json scene;
  std::string messages;
};

class LaterOptions : public testing::Test {
 protected:
  LaterOptions() { bench_.make_ball(); }

  Asked asked(std::vector<std::string> words) const {
    words.insert(words.begin(), {"render", "ball.rho", "--print-scene"});
    const RunResult result = bench_.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return {nlohmann::json::parse(result.out), result.err};
  }

  Workbench bench_;
};

TEST_F(LaterOptions, replace_the_same_option) {
  const Asked found = asked({"--iso", "3", "--size", "64x48", "--iso", "4"});
  EXPECT_EQ(found.scene["layers"][0]["isovalue"], 4);
  EXPECT_THAT(found.messages, HasSubstr("note: --iso 4 replaces --iso 3\n"));
}

TEST_F(LaterOptions, are_quiet_on_request) {
  EXPECT_EQ(asked({"--iso", "3", "--iso", "4", "-q"}).messages, "");
}

TEST_F(LaterOptions, say_nothing_when_they_change_nothing) {
  EXPECT_THAT(asked({"--iso", "4", "--iso", "4"}).messages, Not(HasSubstr("replaces")));
}

TEST_F(LaterOptions, of_a_projection_replace_those_of_a_surface) {
  const Asked found = asked({"--mode", "iso", "--iso", "4", "--surface-color", "red", "--mode", "mip"});
  EXPECT_EQ(found.scene["layers"][0]["type"], "mip");
  EXPECT_THAT(found.messages, HasSubstr("--mode mip replaces --iso 4"));
  EXPECT_THAT(found.messages, HasSubstr("--mode mip replaces --surface-color red"));
}

TEST_F(LaterOptions, of_a_view_replace_a_place_and_the_other_way_round) {
  const Asked view = asked({"--camera-position", "1,2,300", "--camera-target", "0,0,0", "--view", "+z"});
  EXPECT_THAT(view.messages, HasSubstr("--view +z replaces --camera-position 1,2,300"));
  EXPECT_NE(view.scene["camera"]["position"][2], 300);
  const Asked place = asked({"--view", "+z", "--camera-position", "1,2,300"});
  EXPECT_THAT(place.messages, HasSubstr("--camera-position 1,2,300 replaces --view +z"));
  EXPECT_EQ(place.scene["camera"]["position"][2], 300);
}

TEST_F(LaterOptions, choose_between_methods) {
  const Asked found = asked({"--accuracy", "certified", "--method", "paper"});
  EXPECT_EQ(found.scene["layers"][0]["method"], "paper:double");
  EXPECT_THAT(found.messages, HasSubstr("--method paper replaces --accuracy certified"));
}

TEST_F(LaterOptions, that_add_replace_nothing) {
  const Asked found =
      asked({"--slice", "z=3", "--slice", "y=4", "--clip-plane", "0,0,9,0,0,1", "--clip-plane", "0,0,3,0,0,1"});
  EXPECT_EQ(found.scene["layers"].size(), 2U);
  EXPECT_EQ(found.scene["clip"]["planes"].size(), 2U);
  EXPECT_THAT(found.messages, Not(HasSubstr("replaces")));
}

TEST_F(LaterOptions, change_a_printed_command) {
  const RunResult first = bench_.rhoray({"render", "ball.rho", "--iso", "100", "--size", "32x32", "-o", "a.png"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::string printed = line_after(first.err, "reproduce: ");
  EXPECT_EQ(bench_.shell(printed + " -o b.png").exit_code, 0);
  EXPECT_EQ(read_file(bench_ / "a.png").size(), read_file(bench_ / "b.png").size());
  const RunResult projected = bench_.shell(printed + " --mode mip -o c.png");
  EXPECT_EQ(projected.exit_code, 0) << projected.err;
  EXPECT_THAT(projected.err, HasSubstr("--mode mip replaces --iso 100"));
  const RunResult back = bench_.shell(line_after(projected.err, "reproduce: ") + " --mode iso -o d.png");
  EXPECT_EQ(back.exit_code, 0) << back.err;
  const RunResult from_above = bench_.shell(printed + " --view +z -o e.png");
  EXPECT_EQ(from_above.exit_code, 0) << from_above.err;
}

}  // namespace
}  // namespace rhoray::tests
