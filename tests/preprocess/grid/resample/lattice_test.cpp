#include "preprocess/grid/resample/lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/expect_error.h"

namespace rhoray::preprocess {
namespace {

const Box3 box({-1, 0.1, 5}, {3, 2.1, 6});

TEST(SampleLattice, fits_the_longest_axis_from_side_to_side_and_the_others_nearly_as_fine) {
  const SampleLattice lattice = choose_samples(box, {.longest_axis = 101});
  EXPECT_EQ(lattice.count, Index3(101, 51, 26));
  for (int axis = 0; axis < 3; ++axis) {
    const auto& places = lattice.places[static_cast<std::size_t>(axis)];
    EXPECT_EQ(places.front(), box.min[axis]);
    EXPECT_EQ(places.back(), box.max[axis]);
    EXPECT_NEAR(lattice.spacing[axis], 0.04, 0.001);
  }
}

TEST(SampleLattice, takes_a_number_of_samples_for_each_axis) {
  const SampleLattice lattice = choose_samples(box, {.sample_count = {2, 3, 9}});
  EXPECT_EQ(lattice.count, Index3(2, 3, 9));
  EXPECT_EQ(lattice.spacing, Vec3(4, 1, 0.125));
  EXPECT_EQ(lattice.brick_count(), Index3(1, 1, 2));
}

TEST(SampleLattice, keeps_a_spacing_and_ends_at_or_beyond_the_far_side) {
  const SampleLattice lattice = choose_samples(box, {.spacing = {0.1, 0.3, 5}});
  EXPECT_EQ(lattice.count, Index3(41, 8, 2));
  EXPECT_EQ(lattice.spacing, Vec3(0.1, 0.3, 5));
  EXPECT_EQ(lattice.places[0].back(), box.max.x) << "0.1 divides the side but for rounding: no sample beside it";
  EXPECT_GT(lattice.places[1].back(), box.max.y);
  EXPECT_EQ(lattice.places[2].back(), 10);
}

/// Readers of a file calculate places by its spacing: a sample moved by more than rounding would
/// have a value of another place.
TEST(SampleLattice, has_every_sample_where_the_spacing_says) {
  for (const double low : {0.0, -1e6 / 3, 1e8})
    for (const double excess : {-1e-8, -0.9e-9, 0.0, 0.9e-9, 1e-8}) {
      const Box3 long_box({low, 0, 0}, {low + 1000 * (1 + excess), 1, 1});
      const SampleLattice lattice = choose_samples(long_box, {.spacing = {0.01, 0.5, 0.5}});
      const std::vector<double>& places = lattice.places[0];
      EXPECT_GE(places.back(), long_box.max.x);
      EXPECT_LT(places.back(), long_box.max.x + 0.01);
      const double rounding = 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(low), long_box.max.x);
      EXPECT_NEAR(places.back(), low + static_cast<double>(places.size() - 1) * 0.01, rounding) << low << " " << excess;
    }
}

TEST(SampleLattice, refuses_what_makes_no_lattice) {
  tests::expect_error(ErrorCode::usage, "2 to 1048576", [] { choose_samples(box, {.longest_axis = 1}); });
  tests::expect_error(ErrorCode::usage, "y axis: found 1", [] { choose_samples(box, {.sample_count = {4, 1, 4}}); });
  tests::expect_error(ErrorCode::usage, "x axis", [] { choose_samples(box, {.spacing = {1e-9, 1, 1}}); });
  tests::expect_error(ErrorCode::usage, "found -1", [] { choose_samples(box, {.spacing = {1, -1, 1}}); });
}

}  // namespace
}  // namespace rhoray::preprocess
