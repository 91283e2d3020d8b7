#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

// A surface on its way from a foreign file to a picture.
namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// cube.off of six squares, and cube.rho.
void make_cube(const Workbench& bench) {
  write_file(bench / "cube.off",
             "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
             "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n");
  const RunResult packed = bench.rhoray({"pack", "cube.off", "-o", "cube.rho"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  EXPECT_THAT(packed.err, HasSubstr("12 triangles, 8 points"));
  EXPECT_THAT(packed.err, HasSubstr("note: 6 facets of more than three corners cut into triangles"));
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
      {{"--iso", "0.5"}, "--iso: is of fields"},
      {{"--mode", "mip"}, "--mode: is of fields"},
      {{"--color-by", "a"}, "--color-by: is of fields"},
      {{"--range", "0,1"}, "--range: is of fields"},
      {{"--method", "paper"}, "--method: is of fields"},
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
    EXPECT_EQ(run.exit_code, 4) << run.err;
    EXPECT_THAT(run.err, HasSubstr("holds a surface"));
  }
  const RunResult exported = bench.rhoray({"export", "cube.rho", "-o", "x.stl"});
  EXPECT_EQ(exported.exit_code, 7);
  EXPECT_THAT(exported.err, HasSubstr("holds a surface"));
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
