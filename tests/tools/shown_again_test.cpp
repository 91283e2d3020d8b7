#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/workbench.h"
#include "tools/pictures/annotations.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/data_choice.h"

/// Pictures that are drawn again from what they say of themselves, and numbers that keep their
/// digits.
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

TEST(ShownAgain, sheets_beyond_the_limits_are_refused_before_the_first_frame) {
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

TEST(RenderCommand, says_which_options_have_no_effect) {
  const Workbench bench;
  bench.make_ball();
  const auto drawn = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "ball.rho", "--size", "16x16", "-o", "a.png", "--force"});
    return bench.rhoray(words);
  };
  const std::string no_surface = "lights and occlusion have no effect: no layer is a surface";
  EXPECT_THAT(drawn({"--mode", "mip", "--shadows"}).err, HasSubstr(no_surface));
  EXPECT_THAT(drawn({"--slice", "x", "--ao"}).err, HasSubstr(no_surface));
  EXPECT_THAT(drawn({"--iso", "100", "--ao"}).err, testing::Not(HasSubstr("no effect")));
  EXPECT_THAT(drawn({"--mode", "mip"}).err, testing::Not(HasSubstr("no effect")));
  EXPECT_THAT(drawn({"--iso", "100", "--ortho-height", "60", "--zoom", "3"}).err, HasSubstr("zoom has no effect"));
  const RunResult opacity = drawn({"--mode", "mip", "--opacity", "0.2"});
  EXPECT_EQ(opacity.exit_code, 2);
  EXPECT_THAT(opacity.err, HasSubstr("--opacity: needs an isosurface"));
}

/// One value of a million among values of 0 to 1: percentiles say little, and the command says so.
TEST(RenderCommand, says_how_well_it_knows_a_default_range) {
  const Workbench bench;
  std::vector<float> values(16 * 16 * 16);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 100) / 100;
  values[700] = 1e6F;
  write_file(bench / "far.raw",
             std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]));
  const auto drawn = [&](std::vector<std::string> words) {
    words.insert(words.begin(),
                 {"render", "far.raw", "--raw", "16x16x16:float32", "--size", "16x16", "-o", "a.png", "--force"});
    return bench.rhoray(words).err;
  };
  EXPECT_THAT(drawn({"--mode", "mip"}), HasSubstr("is known to within 3.9e+03 only; --range sets another"));
  EXPECT_THAT(drawn({"--mode", "mip", "--range", "0,1"}), testing::Not(HasSubstr("is known to within")));
  EXPECT_THAT(drawn({"--iso", "p95"}), HasSubstr("; to within 3.9e+03, a bin of the histogram"));
  EXPECT_THAT(bench.rhoray({"info", "far.raw", "--raw", "16x16x16:float32"}).out,
              HasSubstr("; each to within 3.9e+03"));
}

/// offset.nrrd: values x + 1e8, and positions 1e6 away from 0 along x, in doubles.
class LargeOffsets : public testing::Test {
 protected:
  void SetUp() override {
    std::string text =
        "NRRD0004\ntype: double\ndimension: 3\nspace dimension: 3\nsizes: 24 24 24\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1000000.5,0,0)\nencoding: raw\nendian: little\n\n";
    for (int n = 0; n < 24 * 24 * 24; ++n) {
      const double value = 1e8 + n % 24;
      text.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    write_file(bench_ / "offset.nrrd", text);
  }

  Workbench bench_;
};

TEST_F(LargeOffsets, info_tells_the_ends_of_ranges_apart) {
  const RunResult info = bench_.rhoray({"info", "offset.nrrd"});
  EXPECT_THAT(info.out, HasSubstr("1e+08 to 100000023"));
  EXPECT_THAT(info.out, HasSubstr("(1000000.5 0 0) to (1000023.5 23 23)"));
}

TEST_F(LargeOffsets, picks_tell_positions) {
  const RunResult run = bench_.rhoray({"render", "offset.nrrd", "--iso", "100000010", "--accuracy", "double", "-o",
                                       "a.png", "--size", "33x33", "--azimuth", "-60", "--pick", "16,16"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("position (1000010.5 "));
}

TEST_F(LargeOffsets, legends_tell_isovalues) {
  render::SceneSpec spec;
  spec.data = {{.name = "", .file = bench_ / "offset.nrrd"}};
  spec.layers = {{.type = render::LayerType::isosurface, .isovalues = {"100000010", "100000020", "100000020.001"}}};
  const std::vector<tools::Legend> legends = tools::annotations_of(tools::resolve_layers(spec), {}).legends;
  ASSERT_EQ(legends.size(), 1U);
  std::vector<std::string> texts;
  for (const tools::Legend::Entry& entry : legends[0].entries) texts.push_back(entry.text);
  EXPECT_THAT(texts, testing::ElementsAre("100000020.001", "100000020", "100000010"));
}

}  // namespace
}  // namespace rhoray::tests
