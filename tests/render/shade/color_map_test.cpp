#include "render/shade/color_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

namespace rhoray::tests {
namespace {

using render::ColorMap;

double srgb_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// CIE 1931 relative luminance of linear sRGB; lightness L* grows with it.
double luminance(const Vec3& color) {
  return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z;
}

void expect_code(const Vec3& color, double red, double green, double blue) {
  constexpr double half_a_step = 0.5;
  EXPECT_NEAR(255 * srgb_of(color.x), red, half_a_step);
  EXPECT_NEAR(255 * srgb_of(color.y), green, half_a_step);
  EXPECT_NEAR(255 * srgb_of(color.z), blue, half_a_step);
}

TEST(ColorMap, grows_lighter_from_end_to_end) {
  for (const ColorMap map : {ColorMap::viridis, ColorMap::magma, ColorMap::inferno, ColorMap::plasma, ColorMap::cividis,
                             ColorMap::cubehelix, ColorMap::gray})
    for (int i = 0; i < 1000; ++i)
      EXPECT_LE(luminance(color_of(map, i / 1000.0)),
                luminance(color_of(map, (i + 1) / 1000.0)) + 1e-3);  // tables hold 8 bits
}

TEST(ColorMap, has_the_colours_of_the_published_tables) {
  // Matplotlib 3.6: first, middle (index 128) and last of 256.
  const double middle = 128.0 / 255;
  expect_code(color_of(ColorMap::viridis, 0), 68, 1, 84);
  expect_code(color_of(ColorMap::viridis, middle), 33, 145, 140);
  expect_code(color_of(ColorMap::viridis, 1), 253, 231, 37);
  expect_code(color_of(ColorMap::magma, 1), 252, 253, 191);
  expect_code(color_of(ColorMap::inferno, 1), 252, 255, 164);
  expect_code(color_of(ColorMap::plasma, 0), 13, 8, 135);
  expect_code(color_of(ColorMap::cividis, 0), 0, 34, 78);
  expect_code(color_of(ColorMap::turbo, 0), 48, 18, 59);
}

TEST(ColorMap, has_a_reverse) {
  for (std::size_t i = 0; i < render::color_maps().size(); i += 2) {
    const auto& [name, map] = render::color_maps()[i];
    const auto& [reverse_name, reverse] = render::color_maps()[i + 1];
    EXPECT_EQ(reverse_name, std::string(name) + "_r");
    for (const double share : {0.0, 0.3, 1.0}) EXPECT_EQ(color_of(reverse, share), color_of(map, 1 - share)) << name;
  }
}

TEST(ColorMap, coolwarm_is_lightest_in_its_middle_and_ends_in_the_papers_colours) {
  for (int i = 0; i < 500; ++i) {
    EXPECT_LT(luminance(color_of(ColorMap::coolwarm, i / 1000.0)),
              luminance(color_of(ColorMap::coolwarm, (i + 1) / 1000.0)));
    EXPECT_LT(luminance(color_of(ColorMap::coolwarm, 1 - i / 1000.0)),
              luminance(color_of(ColorMap::coolwarm, 1 - (i + 1) / 1000.0)));
  }
  expect_code(color_of(ColorMap::coolwarm, 0), 59, 76, 192);
  expect_code(color_of(ColorMap::coolwarm, 0.5), 221, 221, 221);
  expect_code(color_of(ColorMap::coolwarm, 1), 180, 4, 38);
}

TEST(ColorMap, stays_within_colours_that_can_be_shown) {
  for (const auto& [name, map] : render::color_maps())
    for (int i = -10; i <= 1010; ++i) {
      const Vec3 color = color_of(map, i / 1000.0);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(color[c] >= 0 && color[c] <= 1) << name << " at " << i / 1000.0;
    }
}

TEST(ColorTable, is_the_map_within_half_a_step_of_the_code) {
  constexpr Interval<double> range{-3, 5};
  for (const auto& [name, map] : render::color_maps()) {
    const auto table = std::make_unique<render::ColorTable>(map);
    for (int first = 0; first < 1024; first += 64) {
      double values[64];
      for (int i = 0; i < 64; ++i) values[i] = range.lo + (range.hi - range.lo) * (first + i) / 1023.0;
      render::Colors colors;
      table->look_up(values, range, colors);
      for (std::size_t i = 0; i < 64; ++i) {
        const Vec3 color = color_of(map, (first + static_cast<int>(i)) / 1023.0);
        const Vec3 found(colors.red[i], colors.green[i], colors.blue[i]);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(255 * srgb_of(found[c]), 255 * srgb_of(color[c]), 0.5) << name;
      }
    }
  }
}

TEST(ColorTable, is_kept_for_every_map) {
  const double values[64] = {0.3};
  for (const auto& [name, map] : render::color_maps()) {
    render::Colors kept, made;
    render::ColorTable::of(map).look_up(values, {0, 1}, kept);
    render::ColorTable(map).look_up(values, {0, 1}, made);
    EXPECT_TRUE(kept.red == made.red && kept.green == made.green && kept.blue == made.blue) << name;
  }
}

TEST(ColorTable, gives_values_beyond_the_range_the_colours_of_its_ends) {
  const render::ColorTable table(ColorMap::viridis);
  double values[64];
  std::fill_n(values, 64, std::numeric_limits<double>::quiet_NaN());
  values[0] = -1, values[1] = 0, values[2] = 1, values[3] = 7;
  values[4] = std::numeric_limits<double>::infinity(), values[5] = -values[4];
  render::Colors colors;
  table.look_up(values, {0, 1}, colors);
  EXPECT_EQ(colors.red[0], colors.red[1]);
  EXPECT_EQ(colors.red[5], colors.red[1]);
  EXPECT_EQ(colors.red[6], colors.red[1]);
  EXPECT_EQ(colors.green[3], colors.green[2]);
  EXPECT_EQ(colors.green[4], colors.green[2]);
}

}  // namespace
}  // namespace rhoray::tests
