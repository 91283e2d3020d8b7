#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/workbench.h"
#include "tools/pictures/pictures.h"

/// Pictures drawn again by the command and by the scene that they hold, and sheets of frames.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;

/// labels.nrrd: 8^3 bytes, 1 below and 2 above the middle, in a background of 0.
void make_labels(const Workbench& bench) {
  std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n";
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 8; ++j)
      for (int i = 0; i < 8; ++i)
        text += static_cast<char>(std::min({i, j, k}) < 1 || std::max({i, j, k}) > 6 ? 0 : k < 4 ? 1 : 2);
  write_file(bench / "labels.nrrd", text);
}

/// Draws, runs the command that draws the picture again, and draws the scene in the picture.
void expect_same_again(const Workbench& bench, std::vector<std::string> words) {
  words.insert(words.begin(), "render");
  words.insert(words.end(), {"-o", "a.png", "--force", "--size", "40x30"});
  const RunResult first = bench.rhoray(words);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const auto numbers = tools::read_picture(bench / "a.png").numbers;
  const RunResult again = bench.shell(line_after(first.err, "reproduce: ") + " --force");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(tools::read_picture(bench / "a.png").numbers == numbers) << first.err;
  const RunResult scene = bench.rhoray({"render", "a.png", "-o", "b.png", "--force"});
  ASSERT_EQ(scene.exit_code, 0) << scene.err;
  EXPECT_TRUE(tools::read_picture(bench / "b.png").numbers == numbers);
}

TEST(ShownAgain, one_label_of_a_segmentation) {
  const Workbench bench;
  make_labels(bench);
  write_file(bench / "scene.json",
             R"({"data": {"a": {"file": "labels.nrrd", "label": 2}}, "layers": [{"type": "isosurface"}]})");
  expect_same_again(bench, {"scene.json"});
}

TEST(ShownAgain, a_projection_of_a_constant_field) {
  const Workbench bench;
  write_file(bench / "flat.raw", std::string(6 * 6 * 6, '\7'));
  expect_same_again(bench, {"flat.raw", "--raw", "6x6x6:uint8", "--mode", "mip"});
}

TEST(ShownAgain, a_sheet_whose_light_and_fog_follow_the_camera) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "sheet.json", R"({"data": {"b": {"file": "ball.rho"}},
    "layers": [{"type": "isosurface", "isovalue": 100}], "image": {"size": [24, 18], "frames": 4}, "effects": {"fog": {}},
    "lights": [{"type": "directional", "azimuth": 60, "elevation": 20, "from": "camera"}],
    "camera": {"keyframes": [{"time": 0, "azimuth": 0, "zoom": 1}, {"time": 1, "azimuth": 100, "zoom": 2}]}})");
  ASSERT_EQ(bench.rhoray({"render", "sheet.json", "--sheet", "2", "-o", "a.png"}).exit_code, 0);
  ASSERT_EQ(bench.rhoray({"render", "a.png", "--sheet", "2", "-o", "b.png"}).exit_code, 0);
  EXPECT_TRUE(tools::read_picture(bench / "a.png").numbers == tools::read_picture(bench / "b.png").numbers);
}

TEST(Sheet, beyond_the_limits_is_refused_before_the_first_frame) {
  const Workbench bench;
  bench.make_ball();
  const auto sheet = [&](const std::string& size, const std::string& frames) {
    write_file(bench / "sheet.json",
               R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "isosurface", "isovalue": 100}],
    "image": {"size": )" +
                   size + R"(, "antialias": 1, "frames": )" + frames + R"(},
    "camera": {"keyframes": [{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 9}]}})");
    return bench.rhoray({"render", "sheet.json", "--sheet", "1", "--memory", "200K", "-o", "a.png"});
  };
  const RunResult too_large = sheet("[1, 42950]", "100000");
  EXPECT_EQ(too_large.exit_code, 2);
  EXPECT_THAT(too_large.err, HasSubstr("--sheet: found 1x4295000000 pixels; expected sides up to 65536"));
  const RunResult no_memory = sheet("[60, 50]", "4");
  EXPECT_EQ(no_memory.exit_code, 5);
  EXPECT_THAT(no_memory.err, HasSubstr("--memory allows 200.0 KiB"));
  EXPECT_EQ(sheet("[10, 10]", "4").exit_code, 0);
}

}  // namespace
}  // namespace rhoray::tests
