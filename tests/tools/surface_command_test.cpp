#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

// A surface on its way from a foreign file to a picture.
namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

void make_cube(const Workbench& bench) {
  const RunResult packed = bench.make_cube();
  EXPECT_THAT(packed.err, HasSubstr("12 triangles, 8 points"));
  EXPECT_THAT(packed.err, HasSubstr("note: 6 facets with more than three corners cut into triangles"));
}

TEST(SurfaceCommands, pack_and_look_inside) {
  const Workbench bench;
  make_cube(bench);
  const RunResult info = bench.rhoray({"info", "cube.rho", "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const json facts = json::parse(info.out);
  EXPECT_EQ(facts["kind"], "surface");
  EXPECT_EQ(facts["format_version"], "1.3");
  EXPECT_EQ(facts["triangles"], 12);
  EXPECT_EQ(facts["points"], 8);
  EXPECT_EQ(facts["provenance"]["source_name"], "cube.off");
  const RunResult text = bench.rhoray({"info", "cube.rho"});
  EXPECT_THAT(text.out, HasSubstr("cube.rho: packed surface"));
  EXPECT_THAT(text.out, HasSubstr("(0 0 0) to (1 1 1)"));
  const RunResult verify = bench.rhoray({"verify", "cube.rho", "--deep"});
  EXPECT_EQ(verify.exit_code, 0) << verify.out;
  EXPECT_THAT(verify.out, HasSubstr("sound"));
}

TEST(SurfaceCommands, show_a_surface_by_itself) {
  const Workbench bench;
  make_cube(bench);
  const RunResult shown = bench.rhoray(
      {"render", "cube.rho", "-o", "cube.png", "--size", "64x64", "--view", "-y", "--pick", "32,32", "--json"});
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  const json report = json::parse(shown.out);
  EXPECT_EQ(report["mode"], "triangles");
  EXPECT_EQ(report["method"], "float");
  EXPECT_FALSE(report.contains("field"));
  EXPECT_FALSE(report.contains("isovalue"));
  EXPECT_GT(report["statistics"]["hits"], 1000);
  EXPECT_FALSE(report["picks"][0].contains("value"));
  EXPECT_TRUE(report["picks"][0]["cell"] == 2 || report["picks"][0]["cell"] == 3) << report["picks"][0];
  const RunResult text = bench.rhoray({"render", "cube.rho", "-o", "x.png", "--size", "64x64", "--pick", "32,32"});
  EXPECT_THAT(text.out, HasSubstr("depth"));
  EXPECT_THAT(text.out, testing::Not(HasSubstr("value")));
}

TEST(SurfaceCommands, tell_how_a_picture_is_made_again) {
  const Workbench bench;
  make_cube(bench);
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{}, {"--normals", "smooth", "--accuracy", "double", "--surface-color", "#c03020"}}) {
    std::vector<std::string> words{"render", "cube.rho", "-o", "a.png", "--size", "48x48", "--force"};
    words.insert(words.end(), options.begin(), options.end());
    const RunResult first = bench.rhoray(words);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const std::string command = line_after(first.err, "reproduce: ");
    ASSERT_FALSE(command.empty());
    const std::string picture = read_file(bench / "a.png");
    const RunResult again = bench.shell(command + " --force");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(read_file(bench / "a.png"), picture);
  }
}

TEST(SurfaceCommands, refuse_what_asks_for_a_field) {
  const Workbench bench;
  make_cube(bench);
  const std::vector<std::pair<std::vector<std::string>, std::string>> rows{
      {{"--iso", "0.5"}, "--iso: needs a field"},
      {{"--mode", "mip"}, "--mode: needs a field"},
      {{"--color-by", "a"}, "--color-by: needs a field"},
      {{"--range", "0,1"}, "--range: needs a field"},
      {{"--method", "paper"}, "--method: needs a field"},
      {{"--accuracy", "certified"}, "expected float or double"},
      {{"--normals", "exact"}, "a surface"},
      {{"--field", "a"}, "no fields"}};
  for (const auto& [options, sentence] : rows) {
    std::vector<std::string> words{"render", "cube.rho", "-o", "x.png"};
    words.insert(words.end(), options.begin(), options.end());
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 2) << options[0];
    EXPECT_THAT(run.err, HasSubstr(sentence));
    EXPECT_FALSE(std::filesystem::exists(bench / "x.png"));
  }
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"validate", "cube.rho", "--iso", "1"}, {"bench", "phases", "cube.rho"}}) {
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 7) << run.err;
    EXPECT_THAT(run.err, HasSubstr("holds a surface"));
  }
  const RunResult exported = bench.rhoray({"export", "cube.rho", "-o", "x.stl"});
  EXPECT_EQ(exported.exit_code, 7);
  EXPECT_THAT(exported.err, HasSubstr("holds a surface"));
}

TEST(SurfaceCommands, stand_as_landmarks_beside_another_file) {
  const Workbench bench;
  make_cube(bench);
  bench.make_ball();
  const std::vector<std::string> look{"--size", "32x24", "--json", "-o", "p.png", "--force"};
  const auto drawn = [&](std::vector<std::string> first) {
    first.insert(first.begin(), "render");
    first.insert(first.end(), look.begin(), look.end());
    const RunResult run = bench.rhoray(first);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  };
  const json one = drawn({"ball.rho", "--iso", "100", "--landmark", "cube.rho", "--shadows"});
  const std::string bytes = read_file(bench / "p.png");
  ASSERT_EQ(one["scene"]["layers"].size(), 2);
  EXPECT_EQ(one["scene"]["layers"][1]["type"], "triangles");
  EXPECT_EQ(one["scene"]["data"].size(), 2);
  std::filesystem::remove(bench / "p.png");
  EXPECT_EQ(bench.shell(one["reproduce"].get<std::string>()).exit_code, 0);
  EXPECT_TRUE(read_file(bench / "p.png") == bytes);
  std::filesystem::copy_file(bench / "cube.rho", bench / "other.rho");
  EXPECT_EQ(
      drawn({"ball.rho", "--landmark", "cube.rho,other.rho", "--accuracy", "certified"})["scene"]["layers"].size(), 3);
  EXPECT_EQ(drawn({"ball.rho", "--mode", "mip", "--landmark", "cube.rho"})["scene"]["layers"][0]["type"], "mip");

  for (const auto& [file, exit_code, fact, hint] :
       {std::tuple{"ball.rho", 4, "--landmark: ball.rho: is a grid; expected a packed surface", "isosurface"},
        {"cub.rho", 3, "cub.rho: no such file", "did you mean cube.rho?"}}) {
    const RunResult refused = bench.rhoray({"render", "ball.rho", "--landmark", file, "-o", "x.png"});
    EXPECT_EQ(refused.exit_code, exit_code) << file;
    EXPECT_THAT(refused.err, HasSubstr(fact));
    EXPECT_THAT(refused.err, HasSubstr(hint));
    EXPECT_FALSE(std::filesystem::exists(bench / "x.png"));
  }
  write_file(bench / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}]})");
  EXPECT_EQ(bench.rhoray({"render", "s.json", "--landmark", "cube.rho", "-o", "x.png"}).exit_code, 2);
}

TEST(SurfaceCommands, refuse_damaged_files) {
  const Workbench bench;
  make_cube(bench);
  const std::string bytes = read_file(bench / "cube.rho");
  write_file(bench / "short.rho", bytes.substr(0, bytes.size() - 1000));
  EXPECT_EQ(bench.rhoray({"render", "short.rho", "-o", "x.png"}).exit_code, 4);
  std::string changed = bytes;
  changed[0x1004] = static_cast<char>(changed[0x1004] ^ 1);  // in "points"
  write_file(bench / "changed.rho", changed);
  const RunResult run = bench.rhoray({"render", "changed.rho", "-o", "x.png"});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.err, HasSubstr("arrays points,"));
  EXPECT_EQ(bench.rhoray({"verify", "changed.rho"}).exit_code, 4);
  EXPECT_FALSE(std::filesystem::exists(bench / "x.png"));
}

}  // namespace
}  // namespace rhoray::tests
