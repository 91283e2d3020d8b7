#include "render/shade/color_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/shade/field_color.h"
#include "render/shade/intensity.h"

namespace rhoray::tests {
namespace {

using render::ColorMap;
using render::ColorScale;
using render::RayBatch;

TEST(Log2, is_the_logarithm_of_the_c_library) {
  for (const double base : {1e-300, 3e-12, 0.7, 0.70710678118654752, 1.0, 1.4142135623730951, 10.0, 12345.6, 9e300})
    for (int i = 0; i < 1000; ++i) {
      const double number = base * (1 + i / 1000.0);
      EXPECT_NEAR(render::log2_of(number), std::log2(number), 1e-12) << number;
    }
  EXPECT_EQ(render::log2_of(8), 3);
}

TEST(Log2, of_numbers_without_one_is_that_of_the_smallest_number) {
  for (const double number : {0.0, -3.0, 1e-310, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(render::log2_of(number), -1022) << number;
  EXPECT_GE(render::log2_of(std::numeric_limits<double>::infinity()), 1024);
}

TEST(ColorScale, places_equal_ratios_at_equal_distances) {
  const ColorScale log{.is_logarithmic = true};
  EXPECT_NEAR(render::position_of(log, {0.01, 100}, 0.01), 0, 1e-15);
  EXPECT_NEAR(render::position_of(log, {0.01, 100}, 0.1), 0.25, 1e-15);
  EXPECT_NEAR(render::position_of(log, {0.01, 100}, 1), 0.5, 1e-15);
  EXPECT_NEAR(render::position_of(log, {0.01, 100}, 100), 1, 1e-15);
  EXPECT_EQ(render::position_of({}, {0.5, 4.5}, 1.5), 0.25);
}

TEST(ColorScale, gives_effects_the_positions_of_its_values) {
  const ColorScale log{.is_logarithmic = true};
  const Interval<double> range{0.02, 3000};
  double values[RayBatch::group_size], positions[RayBatch::group_size];
  for (std::size_t i = 0; i < RayBatch::group_size; ++i) values[i] = 0.02 * std::pow(1.2, static_cast<double>(i));
  const render::EvenNumbers even = render::spread_evenly(log, range, values, positions);
  EXPECT_EQ(even.range, (Interval<double>{0, 1}));
  for (std::size_t i = 0; i < RayBatch::group_size; ++i)
    EXPECT_NEAR(even.numbers[i], render::position_of(log, range, values[i]), 1e-12);
}

TEST(ColorScale, divides_its_range_into_bands_of_one_colour) {
  const ColorScale four{.levels = 4};
  for (const auto& [position, in_map] :
       {std::pair{-0.1, 0.0}, {0.0, 0.0}, {0.2499, 0.0}, {0.25, 1.0 / 3}, {0.74, 2.0 / 3}, {0.75, 1.0}, {1.0, 1.0}})
    EXPECT_EQ(render::position_in_map(four, position), in_map) << position;
  EXPECT_EQ(render::position_in_map({}, 0.2499), 0.2499);
  for (const bool is_logarithmic : {false, true})
    for (const int levels : {2, 3, 7, 256}) {
      const ColorScale scale{.is_logarithmic = is_logarithmic, .levels = levels};
      const Interval<double> range{0.5, 80};
      double values[RayBatch::group_size], positions[RayBatch::group_size];
      for (std::size_t i = 0; i < RayBatch::group_size; ++i) values[i] = 0.3 + 1.37 * static_cast<double>(i);
      const render::EvenNumbers even = render::spread_evenly(scale, range, values, positions);
      EXPECT_EQ(even.range, (Interval<double>{0, 1}));
      for (std::size_t i = 0; i < RayBatch::group_size; ++i)
        EXPECT_EQ(even.numbers[i], render::position_in_map(scale, render::position_of(scale, range, values[i])))
            << values[i];
    }
}

TEST(ColorScale, finds_the_value_at_a_position) {
  for (const ColorScale& scale : {ColorScale{}, ColorScale{.is_logarithmic = true}})
    for (const double position : {0.0, 0.3, 1.0})
      EXPECT_NEAR(render::position_of(scale, {0.5, 80}, render::value_at(scale, {0.5, 80}, position)), position, 1e-15);
}

TEST(ColorScale, that_is_even_leaves_the_values_as_they_are) {
  const double values[RayBatch::group_size] = {};
  double positions[RayBatch::group_size];
  const render::EvenNumbers even = render::spread_evenly({}, {2, 3}, values, positions);
  EXPECT_EQ(even.numbers, values);
  EXPECT_EQ(even.range, (Interval<double>{2, 3}));
}

TEST(ColorScale, colours_values_without_a_logarithm_like_the_low_end) {
  const ColorScale log{.is_logarithmic = true};
  double values[RayBatch::group_size];
  std::fill_n(values, RayBatch::group_size, 1.0);
  values[1] = 0, values[2] = -5, values[3] = 0.1;
  render::Material surface;
  surface.color = {0.25, 0.5, 0.75};
  surface.color_by = render::FieldColors{.field = "f", .map = ColorMap::viridis, .range = {1, 1000}, .scale = log};
  values[4] = std::numeric_limits<double>::quiet_NaN();
  render::Colors of_field, of_projection{};
  find_field_colors(surface, values, of_field);
  find_intensity(ColorMap::gray, log, {1, 1000}, values, of_projection);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(of_field.green[i], of_field.green[0]);
    EXPECT_EQ(of_projection.green[i], of_projection.green[0]);
  }
  EXPECT_EQ(of_field.green[4], 0.5F) << "no data: the surface's own colour";
}

}  // namespace
}  // namespace rhoray::tests
