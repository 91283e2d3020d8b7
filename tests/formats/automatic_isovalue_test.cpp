#include "formats/automatic_isovalue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace rhoray::formats {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::IsEmpty;

struct Material {
  double value, count, deviation;  ///< bins; samples in the peak's bin; bins
};

/// 256 bins over 0 to 256: a normal distribution for each material, and samples of blurred
/// boundaries everywhere between. The gradient is 1 on every isosurface, and so is the area.
FieldSummary field_with(const std::vector<Material>& materials) {
  FieldSummary field;
  field.range = {0, 256};
  for (int bin = 0; bin < 256; ++bin) {
    double count = 10;
    for (const Material& material : materials)
      count += material.count * std::exp(-0.5 * std::pow((bin - material.value) / material.deviation, 2));
    field.histogram.push_back(static_cast<std::uint64_t>(count));
  }
  field.isosurface_area.assign(256, 1);
  field.mean_gradient.assign(256, 1);
  return field;
}

TEST(AutomaticIsovalue, lies_midway_between_two_materials) {
  const AutomaticIsovalue chosen = *automatic_isovalue(field_with({{40, 100000, 8}, {140, 20000, 8}}));
  EXPECT_TRUE(chosen.is_valley);
  EXPECT_NEAR(chosen.value, 90, 1);
  EXPECT_THAT(chosen.other_valleys, IsEmpty());
}

TEST(AutomaticIsovalue, lies_at_the_strongest_gradient_of_several_valleys_and_names_the_others) {
  FieldSummary field = field_with({{30, 100000, 6}, {120, 50000, 6}, {220, 20000, 6}});
  for (std::size_t bin = 150; bin < 200; ++bin) field.mean_gradient[bin] = 3;
  const AutomaticIsovalue upper = *automatic_isovalue(field);
  EXPECT_TRUE(upper.is_valley);
  EXPECT_NEAR(upper.value, 170, 1);
  EXPECT_THAT(upper.other_valleys, ElementsAre(DoubleNear(75, 1)));

  for (std::size_t bin = 150; bin < 200; ++bin) field.isosurface_area[bin] = 0.1;
  const AutomaticIsovalue lower = *automatic_isovalue(field);
  EXPECT_NEAR(lower.value, 75, 1) << "a ninth of the area outweighs three times the gradient";
  EXPECT_THAT(lower.other_valleys, ElementsAre(DoubleNear(170, 1)));
}

TEST(AutomaticIsovalue, is_not_taken_from_few_samples_however_strong_their_gradient) {
  FieldSummary field = field_with({{30, 100000, 6}, {120, 50000, 6}, {220, 500, 6}});
  for (std::size_t bin = 150; bin < 256; ++bin) field.mean_gradient[bin] = 100;
  field.histogram[250] = 900;  // hot voxels
  const AutomaticIsovalue chosen = *automatic_isovalue(field);
  EXPECT_NEAR(chosen.value, 75, 1);
  EXPECT_THAT(chosen.other_valleys, IsEmpty());
}

TEST(AutomaticIsovalue, prefers_a_valley_with_samples_to_the_edge_of_a_mask) {
  FieldSummary field = field_with({{90, 5000, 6}, {190, 5000, 6}});
  field.histogram[0] = 2000000;
  for (std::size_t bin = 1; bin < 60; ++bin) field.histogram[bin] = 0, field.mean_gradient[bin] = 1.2;
  const AutomaticIsovalue chosen = *automatic_isovalue(field);
  EXPECT_NEAR(chosen.value, 140, 1);
  EXPECT_THAT(chosen.other_valleys, ElementsAre(DoubleNear(45, 2)));
}

TEST(AutomaticIsovalue, does_not_cut_a_wide_hump_in_two) {
  FieldSummary field = field_with({{10, 1000000, 3}});
  for (std::uint64_t bin = 40; bin < 256; ++bin) field.histogram[bin] = 15000 + 20 * bin;
  const AutomaticIsovalue chosen = *automatic_isovalue(field);
  EXPECT_TRUE(chosen.is_valley);
  EXPECT_GT(chosen.value, 20);
  EXPECT_LT(chosen.value, 45) << "midway to the far peak is 132";
}

TEST(AutomaticIsovalue, is_otsus_threshold_without_a_valley) {
  for (const FieldSummary& field : {field_with({{100, 50000, 20}}), field_with({{100, 50000, 30}, {130, 30000, 30}})}) {
    const AutomaticIsovalue chosen = *automatic_isovalue(field);
    EXPECT_FALSE(chosen.is_valley);
    EXPECT_EQ(chosen.value, *otsu_threshold(field));
    EXPECT_EQ(chosen.otsu_threshold, chosen.value);
    EXPECT_THAT(chosen.other_valleys, IsEmpty());
  }
}

TEST(AutomaticIsovalue, is_otsus_threshold_where_that_is_much_stronger) {
  // Noise of air and a mask part the only valley; a body without a peak of its own lies above.
  FieldSummary field = field_with({{2, 1000000, 3}, {30, 900000, 5}, {30, 100000, 80}});
  ASSERT_GT(*otsu_threshold(field), 50);
  EXPECT_TRUE(automatic_isovalue(field)->is_valley);
  for (std::size_t bin = 45; bin < 256; ++bin) field.mean_gradient[bin] = 2;
  const AutomaticIsovalue chosen = *automatic_isovalue(field);
  EXPECT_EQ(chosen.value, *otsu_threshold(field));
  EXPECT_THAT(chosen.other_valleys, ElementsAre(DoubleNear(16, 2)));
}

TEST(AutomaticIsovalue, is_otsus_threshold_of_fields_without_recorded_gradients_and_of_few_values) {
  FieldSummary field = field_with({{40, 100000, 8}, {140, 20000, 8}});
  field.mean_gradient.clear(), field.isosurface_area.clear();
  EXPECT_FALSE(automatic_isovalue(field)->is_valley);
  FieldSummary labels;
  labels.range = {0, 4};
  labels.histogram = {100, 0, 50, 0, 70};
  labels.mean_gradient = labels.isosurface_area = {1, 2, 3, 2, 1};
  EXPECT_EQ(automatic_isovalue(labels)->value, *otsu_threshold(labels));
}

TEST(AutomaticIsovalue, says_nothing_where_all_values_are_equal) {
  EXPECT_FALSE(automatic_isovalue({}));
  FieldSummary field;
  field.range = {4, 4};
  field.histogram = {10};
  EXPECT_FALSE(automatic_isovalue(field));
}

TEST(AutomaticIsovalue, lies_in_the_range_whatever_a_file_claims) {
  constexpr double huge = std::numeric_limits<double>::max();
  for (const double gradient : {0.0, 5e-324, 1e300, huge})
    for (const double area : {0.0, 5e-324, 1e300, huge}) {
      FieldSummary field = field_with({{30, 100000, 6}, {120, 50000, 6}, {220, 20000, 6}});
      field.range = {-huge, huge};
      field.mean_gradient.assign(256, gradient);
      field.isosurface_area.assign(256, area);
      field.histogram[77] = std::numeric_limits<std::uint64_t>::max();
      const AutomaticIsovalue chosen = *automatic_isovalue(field);
      EXPECT_TRUE(field.range.contains(chosen.value));
      for (const double other : chosen.other_valleys) EXPECT_TRUE(field.range.contains(other));
    }
}

}  // namespace
}  // namespace rhoray::formats
