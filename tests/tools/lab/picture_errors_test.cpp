#include "tools/lab/picture_errors.h"

#include <gmock/gmock.h>

#include <limits>
#include <vector>

namespace rhoray::tests {
namespace {

constexpr double none = std::numeric_limits<double>::infinity(), unknown = std::numeric_limits<double>::quiet_NaN();

TEST(DepthErrors, count_what_was_missed_and_invented_and_measure_the_rest_in_voxels) {
  const std::vector<double> truth{1, 2, none, 4, 5, none}, found{1.5, none, 3, 4, 8, none};
  const study::DepthErrors errors = study::depth_errors(truth, found, 0.5);
  EXPECT_EQ(errors.rays, 6U);
  EXPECT_EQ(errors.hits, 4U);
  EXPECT_EQ(errors.missed, 1U);
  EXPECT_EQ(errors.invented, 1U);
  EXPECT_EQ(errors.median, 1);  // of 0, 1 and 6 voxels
  EXPECT_EQ(errors.largest, 6);
  EXPECT_DOUBLE_EQ(errors.share_above_1, 1.0 / 3);  // 1 itself is not above
  EXPECT_TRUE(errors.has_depth);
}

TEST(DepthErrors, know_hits_without_a_distance) {
  const std::vector<double> truth{1, 2, none}, found{unknown, unknown, unknown};
  const study::DepthErrors errors = study::depth_errors(truth, found, 1);
  EXPECT_EQ(errors.missed, 0U);
  EXPECT_EQ(errors.invented, 1U);
  EXPECT_FALSE(errors.has_depth);
}

TEST(LevelErrors, are_in_parts_of_255_of_the_window) {
  const std::vector<double> truth{10, 20, unknown, 40}, found{10, 22, 5, unknown};
  const study::LevelErrors errors = study::level_errors(truth, found, 510);
  EXPECT_EQ(errors.with_data, 3U);
  EXPECT_EQ(errors.missed, 1U);
  EXPECT_EQ(errors.invented, 1U);
  EXPECT_DOUBLE_EQ(errors.mean, 0.5);
  EXPECT_DOUBLE_EQ(errors.largest, 1);
  EXPECT_EQ(errors.share_above_1, 0);
}

}  // namespace
}  // namespace rhoray::tests
