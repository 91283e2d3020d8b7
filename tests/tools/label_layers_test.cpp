#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// labels.nrrd: 20^3 bytes with the labels 1, 5 and 9 in a background of 0.
void make_labels(const Workbench& bench) {
  std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 20 20 20\nencoding: raw\n\n";
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) {
        const bool is_inside = i > 2 && j > 2 && k > 2 && i < 17 && j < 17 && k < 17;
        text += static_cast<char>(!is_inside ? 0 : k < 10 ? 1 : i < 10 ? 5 : 9);
      }
  write_file(bench / "labels.nrrd", text);
}

TEST(LabelLayers, every_label_of_a_segmentation_gets_a_surface) {
  const Workbench bench;
  make_labels(bench);
  const Json shown = bench.drawn({"labels.nrrd"});
  const Json& layers = shown["scene"]["layers"];
  ASSERT_EQ(layers.size(), 3U);
  std::vector<Json> colors;
  for (const Json& layer : layers) {
    EXPECT_EQ(layer["type"], "isosurface");
    EXPECT_EQ(layer["isovalue"], 0.5);
    EXPECT_THAT(colors, Not(testing::Contains(layer["color"])));
    colors.push_back(layer["color"]);
  }
  EXPECT_EQ(shown["scene"]["data"]["label 5"]["label"], 5);
  EXPECT_EQ(shown["scene"]["data"].size(), 3U);
  const RunResult again = bench.shell(shown["reproduce"].get<std::string>() +
                                      " -o again.png && rhoray compare labels.png again.png --fail 0");
  EXPECT_EQ(again.exit_code, 0) << shown["reproduce"] << again.out << again.err;
  EXPECT_THAT(bench.rhoray({"render", "labels.nrrd", "--force"}).err, HasSubstr("holds labels: 1, 5, 9"));
}

TEST(LabelLayers, many_labels_have_different_colours) {
  const Workbench bench;
  std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 150 6 6\nencoding: raw\n\n";
  for (int row = 0; row < 36; ++row)
    for (int i = 0; i < 150; ++i) text += static_cast<char>(i / 5);
  write_file(bench / "many.nrrd", text);
  const Json shown = bench.drawn({"many.nrrd"});
  const Json& layers = shown["scene"]["layers"];
  ASSERT_EQ(layers.size(), 29U);
  for (std::size_t a = 0; a < layers.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      double distance = 0;
      for (std::size_t c = 0; c < 3; ++c)
        distance += std::abs(layers[a]["color"][c].get<double>() - layers[b]["color"][c].get<double>());
      EXPECT_GT(distance, 0.1) << a << ' ' << b;
    }
}

TEST(LabelLayers, an_isovalue_or_a_mode_shows_the_numbers) {
  const Workbench bench;
  make_labels(bench);
  EXPECT_EQ(bench.drawn({"labels.nrrd", "--iso", "3"})["scene"]["layers"].size(), 1U);
  EXPECT_EQ(bench.drawn({"labels.nrrd", "--mode", "iso"})["scene"]["layers"].size(), 1U);
  EXPECT_EQ(bench.drawn({"labels.nrrd", "--mode", "mip"})["scene"]["layers"].size(), 1U);
  bench.make_ball();
  EXPECT_EQ(bench.drawn({"ball.rho"})["scene"]["layers"].size(), 1U);
}

TEST(LabelLayers, labels_that_are_not_there_are_refused) {
  const Workbench bench;
  make_labels(bench);
  bench.make_ball();
  const auto refusal = [&](const std::string& file, const std::string& label) {
    write_file(bench / "s.json", R"({"data": {"d": {"file": ")" + file + R"(", "label": )" + label +
                                     R"(}}, "layers": [{"type": "isosurface", "isovalue": 0.5}]})");
    const RunResult run = bench.rhoray({"render", "s.json"});
    EXPECT_NE(run.exit_code, 0);
    EXPECT_FALSE(std::filesystem::exists(bench / "s.png"));
    return run.err;
  };
  EXPECT_THAT(refusal("labels.nrrd", "4"), HasSubstr("holds the labels 1, 5, 9; expected label 4"));
  EXPECT_THAT(refusal("ball.rho", "4"), HasSubstr("is not a segmentation; expected label 4"));
  EXPECT_THAT(refusal("labels.nrrd", "1.5"), HasSubstr("/data/d/label"));
}

}  // namespace
}  // namespace rhoray::tests
