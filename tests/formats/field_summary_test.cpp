#include "formats/field_summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace rhoray::formats {
namespace {

FieldSummary field_of(const Interval<double>& range, std::vector<std::uint64_t> histogram) {
  FieldSummary field;
  field.range = range;
  field.histogram = std::move(histogram);
  return field;
}

TEST(HistogramBin, bins_are_equal_and_the_last_one_is_closed) {
  const Interval<double> range{-1, 3};
  EXPECT_EQ(histogram_bin(range, 4, -1), 0U);
  EXPECT_EQ(histogram_bin(range, 4, -0.001), 0U);
  EXPECT_EQ(histogram_bin(range, 4, 0), 1U);
  EXPECT_EQ(histogram_bin(range, 4, 2.999), 3U);
  EXPECT_EQ(histogram_bin(range, 4, 3), 3U);
  EXPECT_EQ(histogram_bin({5, 5}, 4, 5), 0U);
  constexpr double huge = std::numeric_limits<double>::max();
  EXPECT_EQ(histogram_bin({-huge, huge}, 10, 0), 5U) << "a range whose width overflows";
  EXPECT_EQ(histogram_bin({-huge, huge}, 10, huge), 9U);
}

TEST(Percentile, is_linear_inside_a_bin) {
  const FieldSummary uniform = field_of({0, 100}, std::vector<std::uint64_t>(10, 7));
  for (const double share : {0.0, 0.05, 0.5, 0.95, 1.0}) EXPECT_NEAR(percentile(uniform, share), 100 * share, 1e-12);

  const FieldSummary steps = field_of({0, 4}, {2, 0, 0, 6});
  EXPECT_DOUBLE_EQ(percentile(steps, 0.25), 1);  // end of the first bin
  EXPECT_DOUBLE_EQ(percentile(steps, 0.125), 0.5);
  EXPECT_DOUBLE_EQ(percentile(steps, 0.625), 3.5);
}

TEST(Percentile, stays_in_the_range_at_the_edges) {
  const FieldSummary field = field_of({-3, 5}, {0, 1, 3});
  EXPECT_LE(percentile(field, 1), 5);
  EXPECT_GE(percentile(field, 0), -3);
  EXPECT_EQ(percentile(field, 7), percentile(field, 1));
  EXPECT_EQ(percentile(field_of({2, 2}, {9}), 0.5), 2);
  EXPECT_EQ(percentile(field_of({2, 3}, {}), 0.5), 3) << "a histogram without bins says nothing";
  EXPECT_TRUE(std::isnan(percentile(field_of({}, {}), 0.5)));
  constexpr double huge = std::numeric_limits<double>::max();
  EXPECT_NEAR(percentile(field_of({-huge, huge}, {1, 1}), 0.5) / huge, 0, 1e-12);
}

TEST(Otsu, threshold_lies_in_the_middle_of_the_gap_between_two_peaks) {
  EXPECT_DOUBLE_EQ(*otsu_threshold(field_of({0, 10}, {5, 5, 0, 0, 0, 0, 0, 0, 5, 5})), 5);
  EXPECT_DOUBLE_EQ(*otsu_threshold(field_of({0, 2}, {1, 1000})), 1);
}

/// The between-class variance by definition, from the counts alone.
double variance_between(const std::vector<std::uint64_t>& histogram, std::size_t edge) {
  double count[2] = {0, 0}, mean[2] = {0, 0};
  for (std::size_t b = 0; b < histogram.size(); ++b) count[b >= edge] += static_cast<double>(histogram[b]);
  for (std::size_t b = 0; b < histogram.size(); ++b)
    mean[b >= edge] += static_cast<double>(b) * static_cast<double>(histogram[b]) / count[b >= edge];
  return count[0] * count[1] * (mean[0] - mean[1]) * (mean[0] - mean[1]);
}

TEST(Otsu, no_other_edge_parts_the_histogram_better) {
  std::vector<std::uint64_t> histogram(64);
  for (std::size_t b = 0; b < 64; ++b) {
    const double x = static_cast<double>(b);
    histogram[b] = static_cast<std::uint64_t>(1 + 900 * std::exp(-(x - 14) * (x - 14) / 50) +
                                              300 * std::exp(-(x - 45) * (x - 45) / 80));
  }
  const double threshold = *otsu_threshold(field_of({0, 64}, histogram));
  const auto edge = static_cast<std::size_t>(threshold);
  ASSERT_EQ(static_cast<double>(edge), threshold);
  for (std::size_t other = 1; other < 64; ++other)
    EXPECT_LE(variance_between(histogram, other), variance_between(histogram, edge) * (1 + 1e-12));
}

TEST(Otsu, says_nothing_where_there_are_no_two_classes) {
  EXPECT_EQ(otsu_threshold(field_of({}, {})), std::nullopt);
  EXPECT_EQ(otsu_threshold(field_of({4, 4}, {10})), std::nullopt);
  EXPECT_EQ(otsu_threshold(field_of({4, 5}, {0, 10, 0})), std::nullopt);
}

}  // namespace
}  // namespace rhoray::formats
