#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/tools/workbench.h"

/// Logarithmic colours and colours in levels, from options and documents to pictures.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;

nlohmann::json layer_of(const Workbench& bench, std::vector<std::string> words) {
  words.insert(words.begin(), "render");
  words.emplace_back("--print-scene");
  const RunResult result = bench.rhoray(words);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out)["layers"][0];
}

std::vector<float> pixels_of(const std::filesystem::path& path) {
  const auto file = OIIO::ImageInput::open(path.string());
  if (!file) throw std::runtime_error(OIIO::geterror());
  std::vector<float> numbers(file->spec().image_pixels() * static_cast<std::size_t>(file->spec().nchannels));
  EXPECT_TRUE(file->read_image(0, 0, 0, file->spec().nchannels, OIIO::TypeDesc::FLOAT, numbers.data()));
  return numbers;
}

TEST(ColorScaleOption, is_named_in_the_scene_only_where_it_is_not_linear) {
  const Workbench bench;
  bench.make_ball();
  EXPECT_FALSE(layer_of(bench, {"ball.rho", "--mode", "mip"}).contains("scale"));
  EXPECT_FALSE(layer_of(bench, {"ball.rho", "--mode", "mip", "--color-scale", "linear"}).contains("scale"));
  EXPECT_EQ(layer_of(bench, {"ball.rho", "--mode", "mip", "--color-scale", "log"})["scale"], "log");
  EXPECT_EQ(layer_of(bench, {"ball.rho", "--slice", "z", "--color-scale", "log"})["scale"], "log");
}

TEST(ColorScaleOption, chooses_a_range_above_0) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  // ball.rho holds whole numbers from 0, box.rho floats: 'height' from 0 to 1.
  EXPECT_EQ(layer_of(bench, {"ball.rho", "--slice", "z", "--color-scale", "log"})["range"][0], 1);
  const nlohmann::json colored =
      layer_of(bench, {"box.rho", "--field", "length", "--color-by", "height", "--color-scale", "log"});
  EXPECT_EQ(colored["range"], nlohmann::json({1e-4, 1.0}));
  EXPECT_EQ(layer_of(bench, {"ball.rho", "--slice", "z", "--color-scale", "log", "--range", "2,30"})["range"],
            nlohmann::json({2.0, 30.0}));
}

TEST(ColorScaleOption, takes_a_map_for_one_sign_even_where_the_field_has_both) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "potential", [](const Vec3& p) { return p.z - 0.25; });
  add_point_field(mesh, "below", [](const Vec3& p) { return -p.z; });
  preprocess::export_mesh(mesh, bench / "box.vtu", false);
  const nlohmann::json even = layer_of(bench, {"box.vtu", "--slice", "y"});
  EXPECT_EQ(even["colormap"], "coolwarm");
  EXPECT_EQ(even["range"], nlohmann::json({-0.75, 0.75}));
  const nlohmann::json log = layer_of(bench, {"box.vtu", "--slice", "y", "--color-scale", "log"});
  EXPECT_EQ(log["colormap"], "viridis");
  EXPECT_EQ(log["range"], nlohmann::json({1e-4 * 0.75, 0.75}));
  const RunResult refused =
      bench.rhoray({"render", "box.vtu", "--field", "below", "--slice", "y", "--color-scale", "log", "-o", "p.png"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--color-scale: field 'below' has no values above 0"));
}

TEST(ColorScaleOption, refuses_ranges_that_reach_0_and_layers_without_such_colours) {
  const Workbench bench;
  bench.make_ball();
  bench.make_cube();
  struct Row {
    std::vector<std::string> words;
    std::string message;
  };
  for (const auto& [words, message] :
       {Row{{"ball.rho", "--mode", "mip", "--range", "0,200"},
            "--range: found 0 to 200; a logarithmic scale needs values above 0"},
        Row{{"ball.rho", "--slice", "z", "--range", "-3,200"},
            "--range: found -3 to 200; a logarithmic scale needs values above 0"},
        Row{{"ball.rho", "--iso", "100"}, "--color-scale: needs --color-by"},
        Row{{"cube.rho"}, "--color-scale: needs a field, and cube.rho holds only triangles"}}) {
    std::vector<std::string> all{"render", "--color-scale", "log", "-o", "p.png"};
    all.insert(all.end(), words.begin(), words.end());
    const RunResult refused = bench.rhoray(all);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr(message));
  }
  write_file(bench / "s.json", R"({"data": {"b": {"file": "ball.rho"}},
                                   "layers": [{"type": "mip", "scale": "log", "range": [-1, 9]}]})");
  const RunResult refused = bench.rhoray({"render", "s.json", "-o", "p.png"});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err,
              HasSubstr("s.json: /layers/0/range: found -1 to 9; a logarithmic scale needs values above 0"));
  EXPECT_THAT(refused.err, HasSubstr("hint: start the range above 0, or use the linear scale"));
}

TEST(ColorScaleOption, brightens_small_values_of_a_projection) {
  const Workbench bench;
  bench.make_ball();
  const auto sum_of = [&](const char* scale) {
    const RunResult drawn = bench.rhoray({"render", "ball.rho", "--mode", "mip", "--range", "1,255", "--color-scale",
                                          scale, "--size", "40x40", "--force", "-o", "p.png"});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    double sum = 0;
    for (const float number : pixels_of(bench / "p.png")) sum += static_cast<double>(number);
    return sum;
  };
  EXPECT_GT(sum_of("log"), 1.3 * sum_of("linear"));
}

TEST(LevelsOption, leaves_a_slice_that_many_colours) {
  const Workbench bench;
  bench.make_ball();
  for (const char* scale : {"linear", "log"}) {
    const RunResult drawn =
        bench.rhoray({"render", "ball.rho", "--slice", "z", "--levels", "5", "--color-scale", scale, "--range", "2,250",
                      "--antialias", "1", "--size", "80x80", "--force", "-o", "p.png"});
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    std::set<std::array<float, 3>> colors;
    const std::vector<float> pixels = pixels_of(bench / "p.png");
    for (std::size_t i = 0; i < pixels.size(); i += 3) colors.insert({pixels[i], pixels[i + 1], pixels[i + 2]});
    EXPECT_EQ(colors.size(), 6U) << scale << ": five, and the background's";
  }
}

TEST(LevelsOption, takes_2_to_256_and_needs_colours_of_values) {
  const Workbench bench;
  bench.make_ball();
  EXPECT_FALSE(layer_of(bench, {"ball.rho", "--mode", "mip"}).contains("levels"));
  EXPECT_EQ(layer_of(bench, {"ball.rho", "--mode", "mip", "--levels", "8"})["levels"], 8);
  for (const char* number : {"1", "257", "2.5", "x"})
    EXPECT_EQ(bench.rhoray({"render", "ball.rho", "--mode", "mip", "--levels", number, "-o", "p.png"}).exit_code, 2);
  const RunResult refused = bench.rhoray({"render", "ball.rho", "--levels", "8", "-o", "p.png"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--levels: needs --color-by"));
}

TEST(ColorScaleOption, is_told_in_commands_that_draw_the_same_again) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"ball.rho", "--mode", "mip", "--color-scale", "log", "--colorbar"},
        {"ball.rho", "--slice", "z", "--color-scale", "log", "--colorbar"},
        {"ball.rho", "--mode", "mip", "--levels", "6", "--colorbar"},
        {"ball.rho", "--slice", "z", "--levels", "3", "--color-scale", "log"},
        {"box.rho", "--field", "length", "--color-by", "height", "--color-scale", "log", "--levels", "4"},
        {"box.rho", "--field", "length", "--color-by", "height", "--color-scale", "log"}}) {
    std::vector<std::string> all{"render", "--size", "80x60", "--force", "-o", "p.png"};
    all.insert(all.end(), words.begin(), words.end());
    const RunResult first = bench.rhoray(all);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const std::string picture = read_file(bench / "p.png");
    const RunResult again = bench.shell(line_after(first.err, "reproduce: ") + " --force");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(read_file(bench / "p.png") == picture) << testing::PrintToString(words);
  }
}

TEST(ColorScaleOption, gives_way_to_a_later_mode) {
  const Workbench bench;
  bench.make_ball();
  const RunResult drawn =
      bench.rhoray({"render", "ball.rho", "--mode", "mip", "--color-scale", "log", "--mode", "iso", "--print-scene"});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_THAT(drawn.err, HasSubstr("--mode iso replaces --color-scale log"));
  const RunResult synonym = bench.rhoray({"render", "ball.rho", "--log", "-o", "p.png"});
  EXPECT_THAT(synonym.err, HasSubstr("--log is --color-scale log here"));
}

}  // namespace
}  // namespace rhoray::tests
