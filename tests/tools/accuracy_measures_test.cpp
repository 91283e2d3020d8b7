#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "tools/rhoray/accuracy/errors.h"
#include "tools/rhoray/accuracy/flip.h"
#include "tools/rhoray/accuracy/html.h"
#include "tools/rhoray/accuracy/picture_errors.h"

namespace rhoray::tests {
namespace {

using namespace tools;

TEST(AccuracyMeasures, count_missed_and_false_rays_as_beyond_every_limit) {
  ErrorList list{.errors = {nothing_there, 0.1F, 0.2F, 0.3F, is_missed, is_false, nothing_there}, .value_errors = {}};
  const ErrorCounts counts = count_errors(list);
  EXPECT_EQ(counts.rays, 7U);
  EXPECT_EQ(counts.true_hits, 4U);
  EXPECT_EQ(counts.missed, 1U);
  EXPECT_EQ(counts.false_hits, 1U);
  EXPECT_NEAR(counts.error->median, 0.2, 1e-7);
  EXPECT_NEAR(counts.error->largest, 0.3, 1e-7);
  EXPECT_DOUBLE_EQ(counts.within(0.25), 2.0 / 5);
  EXPECT_DOUBLE_EQ(counts.within(1e9), 3.0 / 5);
  EXPECT_NEAR(counts.kept_by(0.6), 0.3, 1e-7);
  EXPECT_TRUE(std::isinf(counts.kept_by(0.61)));
}

TEST(AccuracyMeasures, know_how_sure_a_sample_is) {
  // Wilson 1927; figures of Brown, Cai and DasGupta, Statistical Science 16, 2001, for 10 trials.
  const Share half = share_of(5, 10, false), none = share_of(0, 10, false);
  EXPECT_NEAR(half.low, 0.2366, 1e-4);
  EXPECT_NEAR(half.high, 0.7634, 1e-4);
  EXPECT_EQ(none.low, 0);
  EXPECT_NEAR(none.high, 0.2775, 1e-4);
  const Share all = share_of(5, 10, true);
  EXPECT_EQ(all.low, 0.5);
  EXPECT_EQ(all.high, 0.5);
}

using Picture = std::vector<float>;

Picture one_color(int pixels, float r, float g, float b) {
  Picture rgb;
  for (int pixel = 0; pixel < pixels; ++pixel) rgb.insert(rgb.end(), {r, g, b});
  return rgb;
}

TEST(Flip, is_what_its_formulas_give_for_pictures_of_one_colour) {
  const Picture black = one_color(64, 0, 0, 0), white = one_color(64, 1, 1, 1);
  const Flip flip(8, 8, black);
  EXPECT_EQ(mean_of(flip.against(black)), 0);
  // Lightness differs by 100, colour by nothing; the largest distance, green to blue, is 41.276 to the power 1/0.7.
  const double most = 41.2760, knee = 0.4 * most, error = std::pow(100, 0.7);
  EXPECT_NEAR(mean_of(flip.against(white)), 0.95 + (error - knee) / (most - knee) * 0.05, 1e-5);
}

/// FLIP at the middle of a square picture by the paper's sums over the plane, written without regard to time. The
/// colours are greys, whose chroma is 0: what is left is brightness, filtered and compared.
double flip_of_greys(const std::vector<double>& reference, const std::vector<double>& test, int edge) {
  constexpr double ppd = 67.0206, pi = std::numbers::pi;
  const auto at = [&](const std::vector<double>& picture, int x, int y) {
    x = std::clamp(x + edge / 2, 0, edge - 1), y = std::clamp(y + edge / 2, 0, edge - 1);
    return picture[static_cast<std::size_t>(y * edge + x)];
  };
  const auto sum = [&](const std::vector<double>& picture, int radius, auto&& weight) {
    double total = 0;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) total += weight(x, y) * at(picture, x, y);
    return total;
  };
  const auto lightness = [&](const std::vector<double>& picture) {
    const auto bell = [&](int x, int y) { return std::exp(-pi * pi * (x * x + y * y) / (ppd * ppd * 0.0047)); };
    double weights = 0;
    for (int y = -10; y <= 10; ++y)
      for (int x = -10; x <= 10; ++x) weights += bell(x, y);
    const double light = sum(picture, 10, bell) / weights;
    return 116 * (light > 216.0 / 24389 ? std::cbrt(light) : light * 841 / 108 + 4.0 / 29) - 16;
  };
  constexpr double sd = 0.5 * 0.082 * ppd;
  const int radius = static_cast<int>(std::ceil(3 * sd));
  const auto features = [&](const std::vector<double>& picture) {
    const auto bell = [&](int x, int y) { return std::exp(-(x * x + y * y) / (2 * sd * sd)); };
    const auto slope = [&](int x, int y) { return -x * bell(x, y); };
    const auto bend = [&](int x, int y) { return (x * x / (sd * sd) - 1) * bell(x, y); };
    const auto size = [&](auto&& weight) {
      double above = 0, below = 0;
      for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
          const double w = weight(x, y);
          (w > 0 ? above : below) += std::abs(w);
        }
      const auto balanced = [&](double w) { return w > 0 ? w / above : w / below; };
      return std::hypot(sum(picture, radius, [&](int x, int y) { return balanced(weight(x, y)); }),
                        sum(picture, radius, [&](int x, int y) { return balanced(weight(y, x)); }));
    };
    return std::array{size(slope), size(bend)};
  };
  const double difference = std::pow(std::abs(lightness(reference) - lightness(test)), 0.7), knee = 0.4 * 41.2760;
  const double color =
      difference < knee ? 0.95 / knee * difference : 0.95 + (difference - knee) / (0.6 * 41.2760) * 0.05;
  const auto p = features(reference), q = features(test);
  const double feature = std::max(std::abs(p[0] - q[0]), std::abs(p[1] - q[1])) / std::numbers::sqrt2;
  return std::pow(color, 1 - std::sqrt(feature));
}

TEST(Flip, is_the_sum_over_the_plane_at_a_pixel) {
  constexpr int edge = 33;
  std::mt19937 random(5);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<double> reference, test;
    Picture reference_rgb, test_rgb;
    for (int pixel = 0; pixel < edge * edge; ++pixel) {
      const bool is_left = pixel % edge < 12 + trial;
      reference.push_back(is_left ? 0.2 : 0.8);
      test.push_back((pixel % edge < 14 ? 0.2 : 0.7) + 1e-5 * static_cast<double>(random() % 1000));
      for (int c = 0; c < 3; ++c) reference_rgb.push_back(static_cast<float>(reference.back()));
      for (int c = 0; c < 3; ++c) test_rgb.push_back(static_cast<float>(test.back()));
    }
    const std::vector<float> errors = Flip(edge, edge, reference_rgb).against(test_rgb);
    const double expected = flip_of_greys(reference, test, edge);
    EXPECT_NEAR(static_cast<double>(errors[edge * edge / 2]), expected, 2e-4);
    EXPECT_GT(expected, 0.05);
  }
}

TEST(PictureErrors, measure_levels_and_angles) {
  render::Framebuffer black(4, 4, {.normal = true}), grey(4, 4, {.normal = true});
  for (std::size_t pixel = 0; pixel < 16; ++pixel) {
    black.normal[3 * pixel] = 1;
    grey.normal[3 * pixel] = grey.normal[3 * pixel + 1] = 0.70710678F;
    if (pixel == 0) grey.color[0] = 1;  // red of one pixel
  }
  const PictureErrors errors = TruePicture(black).against(grey);
  EXPECT_NEAR(errors.rmse, 255 / std::sqrt(48.0), 1e-9);
  EXPECT_NEAR(errors.normal_deg->median, 45, 1e-5);
}

TEST(PictureErrors, enlarge_linearly_between_the_middles_of_pixels) {
  render::Framebuffer two(2, 1, {});
  two.color = {0, 0, 0, 1, 1, 1, 1, 1};
  const render::Framebuffer four = enlarged(two, 4, 1);
  const std::array<float, 4> expected{0, 0.25F, 0.75F, 1};
  for (std::size_t x = 0; x < 4; ++x) EXPECT_FLOAT_EQ(four.color[4 * x], expected[x]);
}

TEST(Html, spells_text_and_bytes) {
  EXPECT_EQ(html_text("a<b> & `c`"), "a&lt;b&gt; &amp; <code>c</code>");
  // RFC 4648, section 10.
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace rhoray::tests
