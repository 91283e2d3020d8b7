#include "tools/pictures/annotate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "render/render.h"
#include "tests/support/expect_error.h"
#include "tests/tools/blank_picture.h"
#include "tests/tools/workbench.h"
#include "tools/pictures/pictures.h"
#include "tools/pictures/projection.h"

/// Annotations drawn over finished pictures.
namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using namespace tools;

std::vector<std::string> texts(const std::vector<Tick>& ticks) {
  std::vector<std::string> all;
  for (const Tick& tick : ticks) all.push_back(tick.text);
  return all;
}

TEST(Ticks, stand_at_multiples_of_1_2_or_5_times_a_power_of_ten) {
  EXPECT_THAT(texts(ticks_of({0, 1}, 6)), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1.0"));
  EXPECT_THAT(texts(ticks_of({-300, 900}, 8)), ElementsAre("−200", "0", "200", "400", "600", "800"));
  EXPECT_THAT(texts(ticks_of({0.011, 0.034}, 5)), ElementsAre("0.015", "0.020", "0.025", "0.030"));
  EXPECT_THAT(texts(ticks_of({0, 3e6}, 4)), ElementsAre("0", "1e+06", "2e+06", "3e+06"));
  EXPECT_THAT(texts(ticks_of({-0.1, 0.3}, 5)), ElementsAre("−0.1", "0", "0.1", "0.2", "0.3"))
      << "ends that are multiples but for rounding belong to the range";
  EXPECT_THAT(texts(ticks_of({2.5, 2.5}, 5)), ElementsAre("2.5"));
}

TEST(Ticks, are_in_the_range_evenly_and_never_too_many) {
  for (const double lo : {-7.3, 0.0, 1e-7, 12345.6})
    for (const double width : {1e-3, 0.7, 13.0, 9e7})
      for (const int most : {1, 2, 5, 9}) {
        const std::vector<Tick> ticks = ticks_of({lo, lo + width}, most);
        EXPECT_LE(ticks.size(), static_cast<std::size_t>(most));
        if (most >= 5) {
          EXPECT_GE(ticks.size(), 2U) << lo << " and " << width;
        }
        for (std::size_t i = 0; i < ticks.size(); ++i) {
          EXPECT_GE(ticks[i].value, lo - 1e-8 * width);
          EXPECT_LE(ticks[i].value, lo + width * (1 + 1e-8));
          if (i >= 2) {
            EXPECT_NEAR(ticks[i].value - ticks[i - 1].value, ticks[1].value - ticks[0].value, 1e-6 * width);
          }
        }
      }
}

TEST(Ticks, have_labels_that_tell_them_apart) {
  EXPECT_THAT(texts(ticks_of({0, 2e5}, 5)), ElementsAre("0", "5.0e+04", "1.0e+05", "1.5e+05", "2.0e+05"));
  EXPECT_THAT(texts(ticks_of({1e6, 1000023.5}, 2)), ElementsAre("1.00000e+06", "1.00002e+06"));
  for (const double lo : {0.0, -1.0, 10.0})
    for (const int power : {-8, -6, -2, 0, 4, 5, 8, 300})
      for (double hi = 1; hi < 10; hi += 0.7)
        for (const int most : {2, 5, 9}) {
          const double unit = std::pow(10, power);
          const std::vector<Tick> ticks = ticks_of({lo * unit, (lo + hi) * unit}, most);
          for (std::size_t i = 1; i < ticks.size(); ++i) {
            const double step = ticks[i].value - ticks[i - 1].value;
            std::string text = ticks[i].text;
            for (std::size_t at; (at = text.find("\u2212")) != std::string::npos;) text.replace(at, 3, "-");
            EXPECT_NEAR(std::strtod(text.c_str(), nullptr), ticks[i].value, step / 1000) << ticks[i].text;
          }
        }
}

TEST(Ticks, end_where_no_number_tells_the_step) {
  EXPECT_EQ(ticks_of({5e-323, 5e-322}, 5).size(), 1U);
  EXPECT_EQ(ticks_of({-1e308, 1e308}, 5).size(), 1U);
  EXPECT_EQ(ticks_of({1e-300, 3e-300}, 5).size(), 5U);
}

TEST(LogTicks, stand_at_powers_of_ten) {
  const auto labels = [](const Interval<double>& range, int most) {
    std::vector<std::string> all;
    for (const Tick& tick : log_ticks_of(range, most))
      if (!tick.text.empty()) all.push_back(tick.text);
    return all;
  };
  EXPECT_THAT(labels({0.01, 1000}, 9), ElementsAre("0.01", "0.1", "1", "10", "100", "1000"));
  EXPECT_THAT(labels({2e-7, 3e4}, 20),
              ElementsAre("10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹", "10²", "10³", "10⁴"));
  EXPECT_THAT(labels({1e-12, 1e12}, 5), ElementsAre("10⁻¹⁰", "10⁻⁵", "10⁰", "10⁵", "10¹⁰"));
  EXPECT_THAT(labels({3, 80}, 9), ElementsAre("5", "10", "20", "50"));
  EXPECT_THAT(labels({3e7, 8e8}, 9), ElementsAre("5×10⁷", "10⁸", "2×10⁸", "5×10⁸"));
  EXPECT_THAT(labels({310, 340}, 4), ElementsAre("310", "320", "330", "340"));
}

TEST(LogTicks, mark_multiples_between_them_where_there_is_room) {
  const std::vector<Tick> ticks = log_ticks_of({1, 1000}, 9);
  EXPECT_EQ(ticks.size(), 28U);
  EXPECT_EQ(std::count_if(ticks.begin(), ticks.end(), [](const Tick& tick) { return tick.text.empty(); }), 24);
  EXPECT_EQ(log_ticks_of({1e-9, 1e9}, 9).size(), 9U);
}

TEST(BorderTicks, have_as_many_digits_as_a_band_needs) {
  EXPECT_THAT(texts(border_ticks({0, 0.25, 0.5, 0.75, 1}, true, 9)), ElementsAre("0", "0.25", "0.50", "0.75", "1.00"));
  EXPECT_THAT(texts(border_ticks({0, 1.0 / 3, 2.0 / 3, 1}, true, 9)), ElementsAre("0", "0.333", "0.667", "1.000"));
  EXPECT_THAT(texts(border_ticks({-1000, -500, 0, 500}, true, 9)), ElementsAre("−1000", "−500", "0", "500"));
  EXPECT_THAT(texts(border_ticks({0, 2.5e5, 5e5}, true, 9)), ElementsAre("0", "2.5e+05", "5.0e+05"));
  EXPECT_THAT(texts(border_ticks({1, std::sqrt(10), 10, std::sqrt(1000), 100}, false, 9)),
              ElementsAre("1", "3.16", "10", "31.6", "100"));
}

TEST(BorderTicks, have_labels_as_far_apart_as_there_is_room) {
  std::vector<double> borders(13);
  std::iota(borders.begin(), borders.end(), 0.0);
  EXPECT_THAT(texts(border_ticks(borders, true, 7)),
              ElementsAre("0", "", "2", "", "4", "", "6", "", "8", "", "10", "", "12"));
  EXPECT_THAT(texts(border_ticks(borders, true, 6)),
              ElementsAre("0", "", "", "3", "", "", "6", "", "", "9", "", "", "12"));
  borders.resize(12);
  EXPECT_THAT(texts(border_ticks(borders, true, 6)),
              ElementsAre("0", "", "2", "", "4", "", "6", "", "8", "", "10", ""));
  borders.resize(257);
  std::iota(borders.begin(), borders.end(), 0.0);
  EXPECT_THAT(texts(border_ticks(borders, true, 9)),
              ElementsAre("0", "32", "64", "96", "128", "160", "192", "224", "256"));
}

TEST(Canvas, a_line_covers_its_width_times_its_length) {
  for (const Spot& to : {Spot{80, 10}, Spot{10, 80}, Spot{70, 55}}) {
    render::Framebuffer picture = blank(96, 96, 0);
    Canvas(picture, {0, 0, 0}, 0).line({10, 10}, to, 3, {1, 1, 1});
    double sum = 0;
    for (std::size_t p = 0; p < picture.pixel_count(); ++p) sum += static_cast<double>(picture.color[4 * p]);
    const double length = (to - Spot{10, 10}).length();
    EXPECT_NEAR(sum, 3 * length + std::numbers::pi * 1.5 * 1.5, 0.01 * 3 * length) << to.x << ", " << to.y;
  }
}

TEST(Canvas, a_triangle_covers_its_area_and_alpha_grows_with_it) {
  render::Framebuffer picture = blank(96, 96, 0);
  Canvas(picture, {0, 0, 0}, 0).triangle({10.3, 12.1}, {83.2, 31.7}, {40.5, 77.9}, {1, 1, 1});
  double color = 0, alpha = 0;
  for (std::size_t p = 0; p < picture.pixel_count(); ++p) {
    color += static_cast<double>(picture.color[4 * p]);
    alpha += static_cast<double>(picture.color[4 * p + 3]);
  }
  const double area = 0.5 * std::abs(72.9 * 65.8 - 30.2 * 19.6);
  EXPECT_NEAR(color, area, 0.01 * area);
  EXPECT_NEAR(alpha, color, 1e-3);
}

TEST(ColorBar, has_the_maps_colours_in_every_row_and_ticks_where_their_values_are) {
  for (const ColorBar& bar : {ColorBar{"potential (mV)", render::ColorMap::coolwarm, {-3, 5}},
                              ColorBar{"density", render::ColorMap::gray, {-1000, 400}}})
    for (const Side side : {Side::left, Side::right}) {
      render::Framebuffer picture = blank(640, 400);
      const Drawing drawing = annotate({.bars = {bar}, .bars_side = side}, blocks, picture);
      ASSERT_EQ(drawing.bars.size(), 1U);
      const Drawing::Bar& drawn = drawing.bars[0];
      EXPECT_EQ(side == Side::left, drawn.x_end < 320);
      for (int y = drawn.y_begin; y < drawn.y_end; ++y)
        for (int x = drawn.x_begin; x < drawn.x_end; ++x) {
          const Vec3 expected = render::color_of(bar.map, (drawn.y_end - y - 0.5) / (drawn.y_end - drawn.y_begin));
          EXPECT_LT((color_at(picture, x, y) - expected).length(), 1e-6) << x << ", " << y;
        }
      const std::vector<Tick> ticks = ticks_of(bar.range, static_cast<int>(drawn.tick_rows.size()));
      ASSERT_EQ(ticks.size(), drawn.tick_rows.size());
      for (std::size_t i = 0; i < ticks.size(); ++i) {
        const double share = (ticks[i].value - bar.range.lo) / (bar.range.hi - bar.range.lo);
        EXPECT_NEAR(drawn.tick_rows[i], drawn.y_end - share * (drawn.y_end - drawn.y_begin), 1e-9);
        EXPECT_LT(color_at(picture, drawn.x_end + 2, static_cast<int>(drawn.tick_rows[i])).x, 0.9) << "a tick is drawn";
      }
    }
}

TEST(ColorBar, has_even_distances_between_powers_of_ten_on_a_logarithmic_scale) {
  render::Framebuffer picture = blank(640, 400);
  const Drawing drawing =
      annotate({.bars = {{"f", render::ColorMap::viridis, {1, 1000}, {.is_logarithmic = true}}}}, blocks, picture);
  const Drawing::Bar& drawn = drawing.bars[0];
  ASSERT_GE(drawn.tick_rows.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(drawn.tick_rows[i], drawn.y_end - static_cast<double>(i) / 3 * (drawn.y_end - drawn.y_begin), 1e-9);
  EXPECT_EQ(drawing.texts.size(), 5U) << "a title and four numbers";
}

TEST(ColorBar, shows_bands_and_their_borders) {
  render::Framebuffer picture = blank(640, 400);
  const Drawing drawing =
      annotate({.bars = {{"f", render::ColorMap::viridis, {0, 5}, {.levels = 5}}}}, blocks, picture);
  const Drawing::Bar& drawn = drawing.bars[0];
  ASSERT_EQ(drawn.tick_rows.size(), 6U);
  const int x = (drawn.x_begin + drawn.x_end) / 2;
  for (int band = 0; band < 5; ++band) {
    const Vec3 expected = color_of(render::ColorMap::viridis, band / 4.0);
    for (const double at : {0.1, 0.9}) {
      const int y = static_cast<int>(drawn.y_end - (band + at) / 5 * (drawn.y_end - drawn.y_begin));
      EXPECT_LT((color_at(picture, x, y) - expected).length(), 1e-6) << band;
    }
    EXPECT_NEAR(drawn.tick_rows[static_cast<std::size_t>(band)],
                drawn.y_end - band / 5.0 * (drawn.y_end - drawn.y_begin), 1e-9);
  }
}

TEST(Legend, shows_each_colour_before_its_text_opposite_to_the_bars) {
  const Legend legend{.title = "density (HU)", .entries = {{{1, 0, 0}, "500"}, {{0, 0.25, 0}, "\u2212100"}}};
  for (const Side side : {Side::left, Side::right}) {
    render::Framebuffer picture = blank(640, 400);
    const Drawing drawing = annotate(
        {.bars = {{"f", render::ColorMap::viridis, {0, 1}}}, .bars_side = side, .legends = {legend}}, blocks, picture);
    ASSERT_EQ(drawing.swatches.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const Area& swatch = drawing.swatches[i];
      EXPECT_EQ(side == Side::right, swatch.high.x < 320);
      const Spot middle = 0.5 * (swatch.low + swatch.high);
      EXPECT_LT((color_at(picture, static_cast<int>(middle.x), static_cast<int>(middle.y)) - legend.entries[i].color)
                    .length(),
                1e-6);
    }
    EXPECT_LT(drawing.swatches[0].high.y, drawing.swatches[1].low.y);
  }
}

TEST(Legend, says_how_many_colours_have_no_room) {
  Legend legend{.title = "f", .entries = std::vector<Legend::Entry>(50, {{1, 0, 0}, "1"})};
  render::Framebuffer picture = blank(640, 400);
  const Drawing drawing = annotate({.legends = {legend}}, blocks, picture);
  EXPECT_LT(drawing.swatches.size(), 40U);
  EXPECT_EQ(drawing.texts.size(), drawing.swatches.size() + 2) << "a title, and the number of the others";
  for (const Area& text : drawing.texts) EXPECT_LE(text.high.y, 400);
}

TEST(Legend, cuts_names_that_are_too_wide) {
  const Legend legend{.title = "labels",
                      .entries = {{{1, 0, 0}, "left kidney"}, {{0, 0, 1}, std::string(126, 'w') + "\u00f6"}}};
  for (const int width : {160, 640}) {
    render::Framebuffer picture = blank(width, 400);
    const Drawing drawing = annotate({.legends = {legend}}, blocks, picture);
    ASSERT_EQ(drawing.texts.size(), 3U);
    EXPECT_LE(drawing.texts[2].width(), 0.4 * width);
    EXPECT_GT(drawing.texts[2].width(), 0.3 * width);
  }
}

TEST(Axes, point_where_a_camera_of_these_angles_sees_them) {
  for (const bool orthographic : {false, true})
    for (const double azimuth : {0.0, 33.0, -120.0})
      for (const double elevation : {0.0, 25.0, -70.0}) {
        const render::Camera camera =
            render::fit_camera({{-1, -1, -1}, {1, 1, 1}},
                               {.azimuth_deg = azimuth, .elevation_deg = elevation, .orthographic = orthographic}, 1.5);
        render::Framebuffer picture = blank(300, 200);
        const Drawing drawing = annotate({.camera = camera, .axes = true}, blocks, picture);
        const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
        const Spot expected[3] = {
            {std::cos(a), std::sin(a) * std::sin(e)}, {std::sin(a), -std::cos(a) * std::sin(e)}, {0, -std::cos(e)}};
        const double length = 0.075 * 200;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const Spot way = drawing.axes_tips[axis] - drawing.axes_origin;
          EXPECT_NEAR(way.x, length * expected[axis].x, 1e-9) << azimuth << ", " << elevation << ": " << axis;
          EXPECT_NEAR(way.y, length * expected[axis].y, 1e-9) << azimuth << ", " << elevation << ": " << axis;
        }
        EXPECT_LT(drawing.axes_origin.x, 100);
        EXPECT_GT(drawing.axes_origin.y, 100);
      }
}

/// The tips of the arrows and the ends of the box's edges carry the letters of their directions.
TEST(Axes, carry_letters_of_directions_in_a_body) {
  const Box3 box{{-100, -100, -100}, {100, 100, 100}};
  for (const auto& [space, low, high] :
       {std::tuple(formats::Space::ras, "LPI", "RAS"), {formats::Space::lps, "RAI", "LPS"}}) {
    const render::Camera camera = render::fit_camera(box, {.azimuth_deg = 33, .elevation_deg = 25, .zoom = 0.6}, 1.5);
    render::Framebuffer picture = blank(600, 400);
    const Drawing drawing = annotate({.camera = camera, .space = space, .axes = true, .box = box}, blocks, picture);
    ASSERT_EQ(drawing.letters.size(), 9U) << "three arrows, and two ends of three edges";
    const Projection projection(camera, 600, 400);
    const Spot middle = projection.of({0, 0, 0}).at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3 unit(0, 0, 0);
      unit[static_cast<int>(axis)] = 1;
      const Spot way = projection.of(100.0 * unit).at - middle;
      int count = 0;
      for (const Drawing::Letter& each : drawing.letters) {
        if (each.letter != low[axis] && each.letter != high[axis]) continue;
        ++count;
        const bool is_of_arrow = (each.middle - drawing.axes_origin).length() < 45;
        const Spot from = is_of_arrow ? drawing.axes_origin : middle;
        EXPECT_EQ((each.middle - from).dot(way) > 0, each.letter == high[axis]) << axis << each.letter;
      }
      EXPECT_EQ(count, 3);
    }
  }
  render::Framebuffer picture = blank(600, 400);
  const render::Camera camera = render::fit_camera(box, {}, 1.5);
  EXPECT_TRUE(annotate({.camera = camera, .axes = true, .box = box}, blocks, picture).letters.empty());
}

TEST(Projection, sees_points_where_the_cameras_rays_pass) {
  const Workbench bench;
  bench.make_ball();
  const render::Dataset dataset = render::Dataset::load(bench / "ball.rho");
  for (const bool orthographic : {false, true}) {
    const render::Camera camera = render::fit_camera(
        dataset.bounds(), {.azimuth_deg = 41, .elevation_deg = 17, .orthographic = orthographic}, 1.5);
    const Projection projection(camera, 30, 20);
    render::Framebuffer picture;
    render::Scene scene;
    scene.layers[0].isovalue = 100;
    scene.camera = camera;
    render::render(dataset, scene, {.width = 30, .height = 20, .channels = {.depth = true, .cell = true}}, picture);
    int count = 0;
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 30; ++x) {
        const auto p = static_cast<std::size_t>(y * 30 + x);
        if (picture.cell[p] == render::Framebuffer::no_cell) continue;
        const std::uint64_t cell = picture.cell[p], edge = Workbench::ball_edge - 1;
        const Vec3 middle(static_cast<double>(cell % edge) + 0.5, static_cast<double>(cell / edge % edge) + 0.5,
                          static_cast<double>(cell / edge / edge) + 0.5);
        const Seen seen = projection.of(middle);
        const double cell_pixels = 2.0;
        EXPECT_NEAR(seen.at.x, x + 0.5, cell_pixels);
        EXPECT_NEAR(seen.at.y, y + 0.5, cell_pixels);
        EXPECT_NEAR(seen.distance * projection.ray_length(seen.at), static_cast<double>(picture.depth[p]), 1.0);
        ++count;
      }
    EXPECT_GT(count, 30);
  }
}

TEST(Annotations, never_put_text_over_text_or_over_a_bar) {
  const Box3 box{{-120, -40, 0}, {200, 70, 310}};
  for (const auto& [width, height] : {std::pair(640, 480), {300, 700}, {1600, 500}})
    for (const double azimuth : {0.0, 30.0, 75.0, 200.0}) {
      const render::Camera camera = render::fit_camera(box, {.azimuth_deg = azimuth, .elevation_deg = 20, .zoom = 0.75},
                                                       static_cast<double>(width) / height);
      render::Framebuffer picture = blank(width, height);
      const Drawing drawing = annotate(
          {.camera = camera,
           .space = azimuth > 50 ? formats::Space::lps : formats::Space::unknown,
           .axes = true,
           .box = box,
           .length_unit = "mm",
           .bars = {{"a", render::ColorMap::viridis, {0, 7}}, {"another title", render::ColorMap::gray, {-1e-3, 1e-3}}},
           .legends = {{"f (mV)", {{{1, 0, 0}, "1"}, {{0, 1, 0}, "12345"}}}, {"g", {{{0, 0, 1}, "0.5"}}}},
           .caption = "words that take more than one line in a narrow picture"},
          blocks, picture);
      EXPECT_GE(drawing.texts.size(), 12U);
      for (std::size_t i = 0; i < drawing.texts.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j)
          EXPECT_FALSE(drawing.texts[i].overlaps(drawing.texts[j]))
              << width << ", " << azimuth << ": " << i << ", " << j;
        for (const Drawing::Bar& bar : drawing.bars)
          EXPECT_FALSE(
              drawing.texts[i].overlaps({{bar.x_begin - 0.0, bar.y_begin - 0.0}, {bar.x_end + 0.0, bar.y_end + 0.0}}));
        EXPECT_GE(drawing.texts[i].low.x, 0) << i;
        EXPECT_LE(drawing.texts[i].high.x, width) << i;
        EXPECT_LE(drawing.texts[i].high.y, height) << i;
      }
    }
}

TEST(BoxAnnotation, is_hidden_behind_what_is_nearer_and_left_out_before_it) {
  const Box3 box{{-1, -1, -1}, {1, 1, 1}};
  const render::Camera camera = render::fit_camera(box, {.azimuth_deg = 30, .elevation_deg = 20, .zoom = 0.75}, 1);
  const Projection projection(camera, 400, 400);
  // The edges nearest to the eye, at the side, and farthest away.
  const Seen near = projection.of({1, -1, 0.5}), side = projection.of({-1, -1, 0.5}), far = projection.of({-1, 1, 0.5});
  const double between = (near.distance + far.distance) / 2;
  render::Framebuffer picture = blank(400, 400), hidden = blank(400, 400), without_surfaces = blank(400, 400);
  for (float& depth : hidden.depth) depth = static_cast<float>(between);
  const Annotations annotations{.camera = camera, .box = box};
  annotate(annotations, blocks, picture);
  annotate(annotations, blocks, hidden);
  annotate({.camera = camera, .box = box, .hides_box = false}, blocks, without_surfaces);
  const auto darkness = [](const render::Framebuffer& of, const Spot& at) {
    return 1 - color_at(of, static_cast<int>(at.x), static_cast<int>(at.y)).x;
  };
  EXPECT_EQ(darkness(picture, near.at), 0);
  EXPECT_GT(darkness(picture, side.at), 0.3);
  EXPECT_GT(darkness(picture, far.at), 0.3);
  EXPECT_EQ(darkness(hidden, far.at), 0);
  for (const Seen& each : {near, side, far}) EXPECT_GT(darkness(without_surfaces, each.at), 0.3);
}

TEST(Text, has_the_letters_of_many_languages) {
  const std::filesystem::path font = find_font(known_fonts());
  const auto image = [&](const std::string& text) { return make_text_image(text, 40, font); };
  const TextImage missing = image("\U000F1234");  // a private-use character: the font's empty box
  for (const char* letter : {"µ", "é", "°", "−", "Ω", "Ж", "²"}) {
    const TextImage drawn = image(letter);
    EXPECT_GT(drawn.coverage.size(), 0U) << letter;
    EXPECT_FALSE(drawn.coverage == missing.coverage) << letter;
  }
  EXPECT_NEAR(image("−").height, image("-").height, 1) << "a minus is as thick as a hyphen, about";
  EXPECT_GT(image("−").width, image("-").width);
  EXPECT_EQ(image(" ").coverage.size(), 0U);
  EXPECT_GT(image("\xff").coverage.size(), 0U) << "bytes that are no UTF-8 are seen to be none";
  EXPECT_NEAR(image("HH").width, 2.2 * image("H").width, 0.2 * image("H").width);
}

TEST(Text, without_a_font_names_the_package_that_brings_it) {
  expect_error(ErrorCode::unsupported, "annotations need the font DejaVu Sans; there is no /nowhere/DejaVuSans.ttf",
               [] {
                 find_font({"/nowhere/DejaVuSans.ttf", "/nor/here.ttf"});
               });
  try {
    find_font({"/nowhere/DejaVuSans.ttf"});
  } catch (const Error& error) {
    EXPECT_THAT(error.hint(), HasSubstr("fonts-dejavu-core"));
  }
}

}  // namespace
}  // namespace rhoray::tests
