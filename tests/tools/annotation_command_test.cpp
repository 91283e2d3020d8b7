// Annotations in the pictures of `rhoray render`.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

struct Picture {
  int width = 0, height = 0, channels = 0;
  std::vector<std::string> names;
  std::vector<float> values;
};

Picture read(const std::filesystem::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  Picture picture{spec.width, spec.height, spec.nchannels, spec.channelnames, {}};
  picture.values.resize(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, picture.values.data()))
    throw std::runtime_error(input->geterror());
  return picture;
}

TEST(AnnotationCommand, draws_over_colours_and_leaves_channels_and_rays_alone) {
  const Workbench bench;
  bench.make_ball();
  // With a box, the camera would be fitted to it.
  const std::vector<std::string> plain{"render",
                                       "ball.rho",
                                       "--iso",
                                       "100",
                                       "--size",
                                       "200x150",
                                       "--camera-position",
                                       "-40,-60,40",
                                       "--camera-target",
                                       "11,11,11",
                                       "--camera-up",
                                       "0,0,1",
                                       "--channels",
                                       "depth,normal",
                                       "--json",
                                       "-o"};
  const auto with = [&](const char* output, const std::vector<std::string>& more) {
    std::vector<std::string> words = plain;
    words.emplace_back(output);
    words.insert(words.end(), more.begin(), more.end());
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  const auto without = with("plain.exr", {});
  const auto annotated = with("annotated.exr", {"--axes", "--box", "--caption", "Ball"});
  EXPECT_EQ(annotated["statistics"]["rays"], without["statistics"]["rays"]);
  EXPECT_EQ(annotated["scene"]["annotations"],
            nlohmann::json::parse(R"({"axes": true, "box": true, "caption": "Ball"})"));
  EXPECT_FALSE(without["scene"].contains("annotations"));
  const Picture a = read(bench / "plain.exr"), b = read(bench / "annotated.exr");
  ASSERT_EQ(a.names, b.names);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const bool is_color = i % static_cast<std::size_t>(a.channels) < 4;
    if (a.values[i] == b.values[i] || (std::isnan(a.values[i]) && std::isnan(b.values[i]))) continue;
    EXPECT_TRUE(is_color) << a.names[i % static_cast<std::size_t>(a.channels)];
    ++changed;
  }
  EXPECT_GT(changed, 1000U);
}

TEST(AnnotationCommand, tells_the_command_and_the_scene_that_draw_the_same_again) {
  const Workbench bench;
  bench.make_ball();
  for (
      const std::string& document :
      {std::string(R"x("annotations": {"axes": true, "box": true, "colorbar": true, "caption": "Ä ball"})x"),
       std::string(
           R"x("annotations": {"axes": {"corner": "right"}, "colorbar": {"title": "T (µm)", "position": "left"}})x")}) {
    write_file(bench / "s.json", R"({"data": {"data": {"file": "ball.rho"}}, "layers": [{"type": "mip"}],
                                     "image": {"size": [160, 120]}, )" +
                                     document + "}");
    const RunResult first = bench.rhoray({"render", "s.json", "-o", "p.png", "--force"});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const std::string picture = read_file(bench / "p.png");
    const RunResult again = bench.shell(line_after(first.err, "reproduce: ") + " --force");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(read_file(bench / "p.png") == picture) << document;
  }
}

TEST(AnnotationCommand, shows_the_colours_of_a_projection_beside_it) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(
      bench.rhoray({"render", "ball.rho", "--mode", "mip", "--colorbar", "--size", "300x200", "-o", "p.png"}).exit_code,
      0);
  const Picture picture = read(bench / "p.png");
  // Scan columns for the bar: only there, right of the ball, nearly every row is one grey, darker
  // than the row above.
  int rows = 0;
  const auto grey = [&](int x, int y) { return picture.values[static_cast<std::size_t>(3 * (y * picture.width + x))]; };
  int best = 0;
  for (int x = 200; x < 300; ++x) {
    rows = 0;
    for (int y = 1; y < 200; ++y) rows += grey(x, y) < grey(x, y - 1);
    best = std::max(best, rows);
  }
  EXPECT_GT(best, 80) << "nearly every row of the bar is darker than the one above";
}

TEST(AnnotationCommand, refuses_a_bar_where_nothing_is_shown_by_colours) {
  const Workbench bench;
  bench.make_ball();
  const RunResult refused = bench.rhoray({"render", "ball.rho", "--colorbar", "-o", "p.png"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--colorbar: nothing here is coloured by a field"));
}

}  // namespace
}  // namespace rhoray::tests
