#include "tools/lab/plain_grid.h"

#include <gmock/gmock.h>

#include "preprocess/pack_volume.h"
#include "tests/support/expect_error.h"
#include "tests/tools/lab/small_grid.h"

namespace rhoray::tests {
namespace {

using formats::ElementType;

TEST(PlainGrid, gives_the_samples_back_and_lays_turned_axes_along_the_worlds) {
  const TemporaryFolder folder;
  preprocess::NeutralVolume grid = ball_grid(9);
  grid.world_from_grid = {{0, -2, 0}, {3, 0, 0}, {0, 0, 0.5}, {7, 8, 9}};
  preprocess::pack_volume(grid, folder / "grid.rho", {.brick_edge = 8});
  const preprocess::NeutralVolume plain = study::plain_grid(folder / "grid.rho", {});
  EXPECT_EQ(plain.sample_count, grid.sample_count);
  EXPECT_EQ(plain.type, ElementType::U16);
  EXPECT_TRUE(std::ranges::equal(plain.samples, grid.samples));
  EXPECT_EQ(study::spacing_of(plain), Vec3(2, 3, 0.5));
  EXPECT_EQ(plain.world_from_grid.origin, Vec3(0));
}

TEST(PlainGrid, spreads_a_range_over_another_type_and_takes_the_isovalue_along) {
  const preprocess::NeutralVolume grid = ball_grid(9);
  const Interval<double> range{100, 600};
  const preprocess::NeutralVolume bytes = study::converted(grid, ElementType::U8, {0, 1000});
  EXPECT_EQ(bytes.samples.size(), 9U * 9 * 9);
  EXPECT_EQ(std::to_integer<int>(bytes.samples[364]), 255);  // the centre
  EXPECT_EQ(std::to_integer<int>(bytes.samples[363]), 230);  // 900 of 1000, rounded
  EXPECT_DOUBLE_EQ(study::converted_isovalue(350, ElementType::U8, range), 127.5);
  EXPECT_DOUBLE_EQ(study::converted_isovalue(350, ElementType::F32, range), 350);
  const preprocess::NeutralVolume floats = study::converted(grid, ElementType::F32, range);
  float middle = 0;
  std::memcpy(&middle, floats.samples.data() + 364 * sizeof middle, sizeof middle);
  EXPECT_EQ(middle, 1000);
}

}  // namespace
}  // namespace rhoray::tests
