#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

/// Pictures without a background.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;

struct Picture {
  int width = 0, height = 0, channels = 0;
  std::vector<float> numbers;

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  double at(std::size_t pixel, std::size_t channel) const {
    return static_cast<double>(numbers[pixel * static_cast<std::size_t>(channels) + channel]);
  }
};

/// The numbers as the file holds them.
Picture read(const std::filesystem::path& path) {
  OIIO::ImageSpec as_stored;
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  const auto file = OIIO::ImageInput::open(path.string(), &as_stored);
  if (!file) throw std::runtime_error(OIIO::geterror());
  Picture picture{file->spec().width, file->spec().height, file->spec().nchannels, {}};
  picture.numbers.resize(file->spec().image_pixels() * static_cast<std::size_t>(picture.channels));
  EXPECT_TRUE(file->read_image(0, 0, 0, picture.channels, OIIO::TypeDesc::FLOAT, picture.numbers.data()));
  return picture;
}

double linear_of(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}
double code_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// The largest difference, in steps of 8 bits, between a picture with a background, and one without
/// that is composited over it.
double difference(const Picture& without, const Picture& with, double background) {
  double largest = 0;
  for (std::size_t pixel = 0; pixel < without.pixel_count(); ++pixel)
    for (std::size_t c = 0; c < 3; ++c) {
      const double alpha = without.at(pixel, 3);
      const double color = alpha * linear_of(without.at(pixel, c)) + (1 - alpha) * background;
      largest = std::max(largest, std::abs(std::round(255 * code_of(color)) - std::round(255 * with.at(pixel, c))));
    }
  return largest;
}

class TransparentBackground : public testing::Test {
 protected:
  TransparentBackground() { bench_.make_ball(); }

  Picture drawn(std::vector<std::string> words, const std::string& background,
                const std::string& file = "p.png") const {
    words.insert(words.begin(), {"render", "ball.rho", "--size", "120x90", "--force", "--background", background});
    words.insert(words.end(), {"-o", file});
    const RunResult result = bench_.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read(bench_ / file);
  }

  Workbench bench_;
};

TEST_F(TransparentBackground, composited_over_a_colour_is_the_picture_with_that_background) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--iso", "100"},
        {"--iso", "60", "--opacity", "0.4", "--surface-color", "steelblue"},
        {"--mode", "mip"},
        {"--mode", "mip", "--colormap", "viridis", "--levels", "4"},
        {"--slice", "z", "--opacity", "0.5", "--antialias", "1"},  // which pixels get more depends on the background
        {"--iso", "40,100", "--legend", "off", "--antialias", "1"}}) {
    SCOPED_TRACE(testing::PrintToString(words));
    const Picture without = drawn(words, "none");
    ASSERT_EQ(without.channels, 4);
    std::size_t partly = 0, covered = 0;
    for (std::size_t pixel = 0; pixel < without.pixel_count(); ++pixel) {
      partly += without.at(pixel, 3) > 0 && without.at(pixel, 3) < 1;
      covered += without.at(pixel, 3) == 1;
    }
    EXPECT_GT(partly + covered, 500U);
    if (words[0] == "--iso") {
      EXPECT_GT(partly, 50U) << "rims";
    }
    EXPECT_LE(difference(without, drawn(words, "white"), 1), 1);
    EXPECT_LE(difference(without, drawn(words, "black"), 0), 1);
  }
}

TEST_F(TransparentBackground, is_stored_by_tiff_and_exr_and_refused_for_jpeg) {
  const Picture png = drawn({"--iso", "100"}, "none"), tiff = drawn({"--iso", "100"}, "none", "p.tif"),
                exr = drawn({"--iso", "100"}, "none", "p.exr");
  EXPECT_EQ(tiff.channels, 4);
  EXPECT_EQ(tiff.numbers, png.numbers);
  for (std::size_t pixel = 0; pixel < exr.pixel_count(); ++pixel) {
    EXPECT_NEAR(exr.at(pixel, 3), png.at(pixel, 3), 1.0 / 255);
    EXPECT_NEAR(exr.at(pixel, 0), png.at(pixel, 3) * linear_of(png.at(pixel, 0)), 0.01);
  }
  const RunResult refused = bench_.rhoray({"render", "ball.rho", "--background", "none", "-o", "p.jpg"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("p.jpg: JPEG stores no alpha, which background none needs"));
  EXPECT_THAT(refused.err, HasSubstr("hint: use a file name ending in .png, .tif or .exr"));
}

TEST_F(TransparentBackground, is_said_in_scenes_and_commands_that_draw_the_same_again) {
  write_file(bench_ / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "slice", "axis": "z"}],
                                    "image": {"background": "none", "size": [40, 30]}})");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"ball.rho", "--iso", "100", "--background", "none", "--size", "40x30"}, {"s.json"}}) {
    std::vector<std::string> all{"render", "--force", "--json", "-o", "p.png"};
    all.insert(all.end(), words.begin(), words.end());
    const RunResult first = bench_.rhoray(all);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_EQ(nlohmann::json::parse(first.out)["scene"]["image"]["background"], "none");
    const std::string picture = read_file(bench_ / "p.png");
    const RunResult again = bench_.shell(line_after(first.err, "reproduce: ") + " --force");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(read_file(bench_ / "p.png") == picture);
    EXPECT_EQ(bench_.rhoray({"render", "p.png", "--print-scene"}).exit_code, 0) << "the scene is read from the picture";
  }
}

TEST_F(TransparentBackground, has_annotations_in_black_with_a_white_rim) {
  const Picture picture = drawn({"--mode", "mip", "--caption", "Ball", "--axes"}, "none");
  std::size_t black = 0;
  for (std::size_t pixel = 0; pixel < picture.pixel_count() / 8; ++pixel) {
    const std::size_t below = picture.pixel_count() - 1 - pixel;
    black += picture.at(below, 3) > 0.9 && picture.at(below, 0) < 0.2;
  }
  EXPECT_GT(black, 5U);
}

TEST_F(TransparentBackground, is_refused_for_heat_maps) {
  const RunResult refused =
      bench_.rhoray({"render", "ball.rho", "--background", "none", "--show", "cost", "-o", "p.png"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--background none: a heat map fills the picture"));
}

}  // namespace
}  // namespace rhoray::tests
