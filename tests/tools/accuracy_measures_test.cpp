#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "render/truth.h"
#include "tests/support/expect_error.h"
#include "tools/analysis/flip.h"
#include "tools/analysis/heat_map.h"
#include "tools/analysis/page_template.h"
#include "tools/analysis/picture_errors.h"

namespace rhoray::tests {
namespace {

using namespace render;
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

TEST(AccuracyMeasures, tell_the_border_of_a_resampled_mesh_from_its_samples) {
  ErrorList list{.errors = {nothing_there, 0.1F, 0.2F, 9.0F, is_missed, is_missed, is_false},
                 .value_errors = {},
                 .is_border = {0, 0, 0, 1, 1, 0, 1}};
  const ErrorCounts counts = count_errors(list);
  EXPECT_EQ(counts.missed, 2U) << "the sum stays what it is";
  EXPECT_EQ(counts.false_hits, 1U);
  EXPECT_EQ(counts.border, (ErrorCounts::Border{.missed = 1, .false_hits = 1, .off = 1}));
  EXPECT_NEAR(counts.error->largest, 0.2, 1e-7) << "of the samples";
  EXPECT_DOUBLE_EQ(counts.within(9), 3.0 / 6) << "and nothing is hidden from what is promised";
  list.is_border.clear();
  EXPECT_EQ(count_errors(list).border, std::nullopt);
  EXPECT_EQ(count_errors(list).error->largest, 9);
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
  // Lightness differs by 100, colour by nothing. The largest distance, green to blue, is 41.276 to
  // the power 1/0.7.
  const double most = 41.2760, knee = 0.4 * most, error = std::pow(100, 0.7);
  EXPECT_NEAR(mean_of(flip.against(white)), 0.95 + (error - knee) / (most - knee) * 0.05, 1e-5);
}

/// FLIP at the centre of a square picture, by the paper's sums over the plane, without regard to
/// run time. The colours are greys with chroma 0, so only brightness is filtered and compared.
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

using PixelColor = std::function<std::array<float, 3>(int x, int y)>;

Picture picture_of(int width, int height, const PixelColor& color) {
  Picture rgb;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const float part : color(x, y)) rgb.push_back(part);
  return rgb;
}

struct KnownPixel {
  int x, y;
  double flip;
};

/// A pair of pictures of linear colours, and the result of the authors' program for it.
struct KnownPair {
  const char* name;
  int width, height;
  PixelColor reference, test;
  double mean, largest;
  std::vector<KnownPixel> pixels;
};

PixelColor waves(float f, float g, float phase) {
  return [=](int x, int y) {
    const auto u = static_cast<float>(x), v = static_cast<float>(y);
    return std::array{0.5F + 0.4F * std::sin(f * u + phase), 0.5F + 0.4F * std::sin(g * v - phase),
                      0.5F + 0.3F * std::sin(f * u + g * v)};
  };
}

PixelColor disc(float middle_x, float middle_y, float radius) {
  return [=](int x, int y) {
    const float u = static_cast<float>(x), v = static_cast<float>(y);
    const float du = u - middle_x, dv = v - middle_y;
    if (du * du + dv * dv >= radius * radius) return std::array{1.0F, 1.0F, 1.0F};
    return std::array{0.8F, 0.4F - 0.005F * u, 0.1F + 0.01F * v};
  };
}

/// A colour for each pixel that depends on its position alone.
PixelColor noise(std::uint32_t seed) {
  return [=](int x, int y) {
    std::array<float, 3> color{};
    for (std::uint32_t c = 0; c < 3; ++c) {
      std::uint32_t mixed = (static_cast<std::uint32_t>(x) * 73856093U) ^ (static_cast<std::uint32_t>(y) * 19349663U) ^
                            ((c + 1) * 83492791U) ^ (seed * 2654435761U);
      mixed ^= mixed >> 13;
      mixed *= 0x5bd1e995U;
      mixed ^= mixed >> 15;
      color[c] = static_cast<float>(mixed % 1000) / 999.0F;
    }
    return color;
  };
}

// The numbers are those of the authors' program (version 1.6, function `evaluate` for pictures of
// 8-bit range, at its default of 67.0206 pixels per degree), run once on these pairs. It computes
// in single precision. Its sums of some hundred weights are good to about 1e-6. FLIP raises errors
// to the power 0.3, so a small error becomes up to 1e-5 (edges of the disc, where nothing differs).
TEST(Flip, says_what_the_authors_program_says) {
  const std::vector<KnownPair> pairs{
      {"waves",
       48,
       40,
       waves(0.31F, 0.23F, 0),
       waves(0.33F, 0.21F, 0.2F),
       0.5451518,
       0.8896320,
       {{0, 0, 0.3537030}, {24, 20, 0.4531669}, {47, 39, 0.6735812}, {16, 10, 0.3554817}, {12, 26, 0.7808303}}},
      {"disc",
       64,
       48,
       disc(30, 24, 15),
       disc(31.5F, 24, 15),
       0.0707785,
       0.8707109,
       {{0, 0, 0}, {32, 24, 0}, {63, 47, 0}, {21, 12, 0.4333756}, {16, 32, 0.3172372}}},
      {"noise",
       40,
       40,
       noise(1),
       noise(2),
       0.3928974,
       0.9572152,
       {{0, 0, 0.9572152}, {20, 20, 0.3836885}, {39, 39, 0.6387793}, {13, 10, 0.3311955}, {10, 26, 0.2916914}}}};
  for (const KnownPair& pair : pairs) {
    SCOPED_TRACE(pair.name);
    const Flip flip(pair.width, pair.height, picture_of(pair.width, pair.height, pair.reference));
    const std::vector<float> errors = flip.against(picture_of(pair.width, pair.height, pair.test));
    EXPECT_NEAR(mean_of(errors), pair.mean, 1e-6);
    EXPECT_NEAR(static_cast<double>(*std::max_element(errors.begin(), errors.end())), pair.largest, 1e-5);
    for (const KnownPixel& pixel : pair.pixels)
      EXPECT_NEAR(static_cast<double>(errors[static_cast<std::size_t>(pixel.y * pair.width + pixel.x)]), pixel.flip,
                  1e-5)
          << pixel.x << "," << pixel.y;
  }
}

TEST(PictureErrors, measure_levels_and_angles) {
  render::Framebuffer black(4, 4, {.normal = true}), grey(4, 4, {.normal = true});
  for (std::size_t pixel = 0; pixel < 16; ++pixel) {
    black.normal[3 * pixel] = 1;
    grey.normal[3 * pixel] = grey.normal[3 * pixel + 1] = 0.70710678F;
    if (pixel == 0) grey.color[0] = 1;  // red channel of one pixel
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

TEST(HeatMap, grows_brighter_with_the_error_and_makes_single_wrong_pixels_seen) {
  std::vector<float> errors(10 * 5, nothing_there);
  errors[0] = 1e-9F, errors[2] = 1e-4F, errors[4] = 2;  // in the first row
  errors[3 * 10 + 3] = is_missed, errors[3 * 10 + 8] = is_false;
  const render::Framebuffer map = heat_map({.width = 10, .height = 5, .errors = errors}, {.unit = "cells"});
  const auto at = [&](std::size_t x, std::size_t y) {
    const float* const pixel = &map.color[4 * (10 * y + x)];
    return Vec3(pixel[0], pixel[1], pixel[2]);
  };
  EXPECT_EQ(at(1, 0), Vec3(1, 1, 1));
  EXPECT_LT(at(0, 0).y, at(2, 0).y);
  EXPECT_LT(at(2, 0).y, at(4, 0).y);
  const Vec3 missed = at(3, 3), wrong = at(8, 3);
  EXPECT_GT(missed.x, 4 * std::max(missed.y, missed.z));
  EXPECT_GT(std::min(wrong.x, wrong.z), 4 * wrong.y);
  EXPECT_EQ(at(2, 2), missed);
  EXPECT_EQ(at(4, 4), missed);
  EXPECT_EQ(at(9, 2), wrong);
  EXPECT_EQ(at(5, 3), Vec3(1, 1, 1));
  const Json legend = legend_json({.unit = "cells"});
  EXPECT_EQ(legend["stops"].get<std::string>().substr(0, 12), "rgb(68,1,84)") << "viridis begins dark";
  EXPECT_EQ(legend["marks"].size(), 3U);
}

TEST(Html, spells_text_and_bytes) {
  EXPECT_EQ(html_text("a<b> & `c`"), "a&lt;b&gt; &amp; <code>c</code>");
  EXPECT_EQ(with_powers("4.2e-07 of <code>1e-05</code>, 1e+06, 0x1e, 2e5"),
            "4.2 × 10<sup>−7</sup> of <code>1e-05</code>, 10<sup>6</sup>, 0x1e, 2e5");
  // RFC 4648, section 10.
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(PageTemplate, shows_values_in_their_formats) {
  const Json values{{"text", "<a> `b` 2e-05"}, {"number", 1.25e-8}, {"count", 1234567}, {"none", nullptr}};
  EXPECT_EQ(fill_template("{{text}}|{{text|html}}", values), "&lt;a&gt; <code>b</code> 2e-05|<a> `b` 2e-05");
  EXPECT_EQ(fill_template("{{text|powers}}", values), "&lt;a&gt; <code>b</code> 2 × 10<sup>−5</sup>");
  EXPECT_EQ(fill_template("{{number|2}} {{count|2}} {{count|grouped}} {{count|bytes}} {{none|2}}", values),
            "1.2 × 10<sup>−8</sup> 1234567 1,234,567 1.2 MiB –");
  expect_error(ErrorCode::internal, "no value 'nothing'", [&] { fill_template("{{nothing}}", values); });
}

TEST(PageTemplate, repeats_sections_and_leaves_empty_ones_out) {
  const Json values{{"name", "outer"},
                    {"list", {{{"x", 1}}, {{"x", 2}, {"name", "inner"}}}},
                    {"words", {"a", nullptr}},
                    {"yes", true},
                    {"no", false},
                    {"zero", 0},
                    {"blank", ""}};
  EXPECT_EQ(fill_template("{{#list}}{{x}} {{name}};{{/list}}", values), "1 outer;2 inner;");
  EXPECT_EQ(fill_template("{{#words}}[{{.}}]{{/words}}", values), "[a][–]");
  EXPECT_EQ(
      fill_template("{{#yes}}y{{/yes}}{{#no}}n{{/no}}{{^no}}N{{/no}}{{#zero}}0{{/zero}}{{#blank}}b{{/blank}}", values),
      "yN0");
  EXPECT_EQ(fill_template("{{#gone}}{{#list}}{{missing}}{{/list}}{{/gone}}{{^gone}}-{{/gone}}", values), "-");
}

}  // namespace
}  // namespace rhoray::tests
