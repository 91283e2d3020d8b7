#include "preprocess/mesh/leaf_lists/choose_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/error.h"

namespace rhoray::preprocess {
namespace {

TEST(ChooseLattice, makes_about_as_many_nearly_cubic_leaf_cells_as_asked) {
  for (const Vec3& extent : {Vec3(1, 1, 1), Vec3(3, 2, 1), Vec3(1e-3, 2e-3, 5e-3), Vec3(1e6, 3e6, 2e6)})
    for (const double request : {100.0, 5000.0, 1e6}) {
      const auto lattice = choose_lattice(Box3(Vec3(-7, 5, 100) * extent.x, Vec3(-7, 5, 100) * extent.x + extent),
                                          {.leaf_cell_count = request});
      const auto leaves = static_cast<double>(volume(lattice.macro.leaf_count));
      EXPECT_NEAR(leaves / request, 1, 0.35);
      const Vec3& size = lattice.leaf_size;
      EXPECT_LT(std::max({size.x, size.y, size.z}) / std::min({size.x, size.y, size.z}), 1.4);
    }
}

TEST(ChooseLattice, reaches_beyond_the_box_on_every_side_by_a_small_part_of_a_leaf_cell) {
  const Box3 box(Vec3(-1, 2, 1000), Vec3(1, 7, 1001));
  const auto lattice = choose_lattice(box, {.leaf_cell_count = 300});
  for (int axis = 0; axis < 3; ++axis) {
    const double size = lattice.leaf_size[axis];
    const double high = lattice.low[axis] + static_cast<double>(lattice.macro.leaf_count[axis]) * size;
    EXPECT_GT(box.min[axis] - lattice.low[axis], size * 0x1p-11);
    EXPECT_LT(box.min[axis] - lattice.low[axis], size * 0x1p-9);
    EXPECT_GT(high - box.max[axis], size * 0x1p-11);
    EXPECT_LT(high - box.max[axis], size * 0x1p-9);
  }
}

TEST(ChooseLattice, gives_a_thin_box_one_layer_and_the_asked_number_in_it) {
  const auto plate = choose_lattice(Box3(Vec3(0, 0, 0), Vec3(10, 1e-6, 20)), {.leaf_cell_count = 5000});
  EXPECT_EQ(plate.macro.leaf_count.y, 1);
  EXPECT_NEAR(static_cast<double>(volume(plate.macro.leaf_count)), 5000, 500);
  const auto rod = choose_lattice(Box3(Vec3(0, 0, 0), Vec3(1e-5, 1e-6, 20)), {.leaf_cell_count = 5000});
  EXPECT_EQ(rod.macro.leaf_count, Index3(1, 1, 5000));
}

TEST(ChooseLattice, refuses_options_that_make_no_sense) {
  const Box3 box(Vec3(0, 0, 0), Vec3(1, 1, 1));
  for (const double request : {0.0, -5.0, 1e12, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(choose_lattice(box, {.leaf_cell_count = request}), Error);
  EXPECT_THROW(choose_lattice(box, {.macro_factor = 1}), Error);
  EXPECT_THROW(choose_lattice(box, {.macro_factor = 33}), Error);
  EXPECT_THROW(choose_lattice(box, {.macro_level_count = 0}), Error);
  EXPECT_THROW(choose_lattice(box, {.macro_level_count = 13}), Error);
}

}  // namespace
}  // namespace rhoray::preprocess
