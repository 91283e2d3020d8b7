#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

/// The size of pictures for which none is given.
namespace rhoray::tests {
namespace {

using Json = nlohmann::json;

/// The JSON output of `rhoray render`.
Json drawn(const Workbench& bench, std::vector<std::string> words) {
  words.insert(words.begin(), "render");
  words.insert(words.end(), {"--json", "--force", "--antialias", "1"});
  const RunResult run = bench.rhoray(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return Json::parse(run.out);
}

double aspect_of(const Json& shown) {
  const Json& size = shown["scene"]["image"]["size"];
  const double width = size[0], height = size[1];
  EXPECT_NEAR(width * height, 960 * 720, 1500) << "rounded to even numbers";
  return width / height;
}

/// A mesh of a box with edges of these lengths, and a field.
void make_mesh(const Workbench& bench, const std::string& name, const Vec3& lengths) {
  preprocess::NeutralMesh mesh = box_mesh({.cells = {2, 2, 2}, .box = {{0, 0, 0}, lengths}});
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  preprocess::export_mesh(mesh, bench / name, false);
}

TEST(PictureSize, is_as_wide_as_what_is_shown) {
  const Workbench bench;
  make_mesh(bench, "box.vtu", {3, 1, 2});
  // Seen without perspective from the front, a box is as wide and high as its side.
  const auto aspect = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"box.vtu", "--surface-color", "gray", "--ortho"});
    return aspect_of(drawn(bench, words));
  };
  const double rounding = 4e-3;  // two pixels of some 600
  EXPECT_NEAR(aspect({"--view", "front"}), 1.5, rounding);
  EXPECT_NEAR(aspect({"--view", "front", "--zoom", "3"}), 1.5, rounding);
  EXPECT_NEAR(aspect({"--view", "right"}), 2.0 / 3, rounding) << "narrower shapes get no narrower pictures";
  EXPECT_NEAR(aspect({"--view", "top"}), 2, rounding) << "wider shapes get no wider pictures";
  EXPECT_NEAR(aspect({"--view", "front", "--clip-box", "0,0,0,2,1,2"}), 1, rounding);
}

TEST(PictureSize, has_room_for_scales_beside_what_is_shown) {
  const Workbench bench;
  make_mesh(bench, "box.vtu", {3, 1, 2});
  const auto aspect = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"box.vtu", "--mode", "boundary", "--ortho", "--view", "front"});
    return aspect_of(drawn(bench, words));
  };
  EXPECT_NEAR(aspect({}), 1.5, 4e-3);
  EXPECT_NEAR(aspect({"--colorbar"}), 1.5 + 0.14, 4e-3);
}

TEST(PictureSize, fills_the_picture_in_perspective_to_a_few_percent) {
  const Workbench bench;
  make_mesh(bench, "box.vtu", {3, 1, 2});
  // The corners of the box in the picture's corners: those that rays hit.
  const Json shown = drawn(bench, {"box.vtu", "--surface-color", "gray", "--stats"});
  const Json& stats = shown["statistics"];
  ASSERT_TRUE(stats.contains("hits")) << stats;
  const double coverage = stats["hits"].get<double>() / stats["rays"].get<double>();
  EXPECT_GT(coverage, 0.5) << "a box seen from a corner covers some two thirds of its rectangle";
}

TEST(PictureSize, that_is_given_is_kept_and_a_given_camera_has_the_usual_one) {
  const Workbench bench;
  make_mesh(bench, "box.vtu", {3, 1, 2});
  const Json size = drawn(bench, {"box.vtu", "--size", "120x50"})["scene"]["image"]["size"];
  EXPECT_EQ(size, Json({120, 50}));
  const Json usual =
      drawn(bench, {"box.vtu", "--camera-position", "5,-9,4", "--camera-target", "1,1,1"})["scene"]["image"]["size"];
  EXPECT_EQ(usual, Json({960, 720}));
}

TEST(PictureSize, is_the_same_for_all_frames_of_a_sweep) {
  const Workbench bench;
  make_mesh(bench, "box.vtu", {3, 1, 2});
  write_file(bench / "s.json", R"({"data": {"m": {"file": "box.vtu"}}, "layers": [{"type": "boundary"}],
    "image": {"antialias": 1}, "camera": {"keyframes": [{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 90}]}})");
  const RunResult run = bench.rhoray({"render", "s.json", "--frames", "2", "-o", "f_%04d.png"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"f_0000.png", "f_0001.png"}) {
    const std::string png = read_file(bench / name);
    EXPECT_EQ(png.substr(16, 8), std::string("\0\0\x03\xC0\0\0\x02\xD0", 8)) << name << ": 960 x 720";
  }
}

}  // namespace
}  // namespace rhoray::tests
