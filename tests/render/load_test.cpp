#include "render/load.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "formats/base/error.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Dataset;

TEST(VolumeLoad, takes_the_named_field_or_the_first_and_refuses_others_with_the_names_there_are) {
  TemporaryFolder folder;
  auto mesh = box_mesh({.cells = {2, 2, 2}}, linear_field({1, 0, 0}));
  add_point_field(mesh, "other", linear_field({0, 5, 0}));
  preprocess::pack_mesh(mesh, folder / "mesh.rho");
  const Dataset first = Dataset::load(folder / "mesh.rho"), other = Dataset::load(folder / "mesh.rho", "other");
  EXPECT_EQ(first.field().name, "value");
  EXPECT_EQ(other.field().name, "other");
  EXPECT_EQ(other.field().range.hi, 5);
  EXPECT_EQ(first.field_names(), (std::vector<std::string>{"value", "other"}));
  EXPECT_TRUE(first.is_mesh());
  try {
    Dataset::load(folder / "mesh.rho", "pressure");
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage);
    for (const char* name : {"mesh.rho", "pressure", "value", "other"})
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
  }
}

TEST(VolumeLoad, refuses_a_missing_file) {
  TemporaryFolder folder;
  EXPECT_THROW(Dataset::load(folder / "nothing.rho"), Error);
}

TEST(VolumeBounds, are_those_of_the_cells_in_the_world) {
  Affine map{{0, 2, 0}, {-3, 0, 0}, {0, 0, 0.5}, {10, 20, 30}};
  const TracedDataset grid(volume_of<std::uint8_t>(
      {5, 3, 4}, [](const Index3&) { return 1; }, map));
  EXPECT_EQ(grid.dataset().bounds().min, Vec3(10 - 6, 20, 30));
  EXPECT_EQ(grid.dataset().bounds().max, Vec3(10, 20 + 8, 30 + 1.5));
  EXPECT_FALSE(grid.dataset().is_mesh());
  const Box3 box({-1, 5, 100}, {3, 6, 108});
  const TracedDataset mesh(box_mesh({.cells = {2, 2, 2}, .box = box}, linear_field({1, 0, 0})));
  EXPECT_LT((mesh.dataset().bounds().min - box.min).length(), 1e-12);
  EXPECT_LT((mesh.dataset().bounds().max - box.max).length(), 1e-12);
}

TEST(IsosurfaceBounds, hold_the_surface_and_little_more) {
  const auto field = distance_field({20, 20, 20});
  const TracedDataset grid(sampled_volume<float>({41, 41, 41}, {}, field));
  const TracedDataset mesh(box_mesh({.cells = {10, 10, 10}, .box = Box3({0, 0, 0}, {40, 40, 40})}, field));
  for (const TracedDataset* traced : {&grid, &mesh}) {
    const Box3 box = traced->dataset().isosurface_bounds(8);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(box.min[axis], 12);
      EXPECT_GE(box.min[axis], 4);
      EXPECT_GE(box.max[axis], 28);
      EXPECT_LE(box.max[axis], 36);
    }
    EXPECT_TRUE(traced->dataset().isosurface_bounds(1000).isEmpty());
    EXPECT_TRUE(traced->dataset().isosurface_bounds(-1).isEmpty());
  }
}

// The distances of tangent planes from the middle of a ball of radius 8. Cells have an edge of 1 in
// the grid and of 4 in the mesh, whose facets cut off a little of the ball.
TEST(ShownBoxes, hold_the_surface_and_little_more_in_every_direction) {
  const auto field = distance_field({20, 20, 20});
  const TracedDataset grid(sampled_volume<float>({41, 41, 41}, {}, field));
  const TracedDataset mesh(box_mesh({.cells = {10, 10, 10}, .box = Box3({0, 0, 0}, {40, 40, 40})}, field));
  Dice dice(5);
  for (const TracedDataset* traced : {&grid, &mesh}) {
    const auto boxes = traced->dataset().shown_boxes(8);
    EXPECT_LT(boxes.size(), 128U * 128U);
    for (int i = 0; i < 200; ++i) {
      const Vec3 direction = dice.direction();
      double farthest = 0;
      for (const auto& corners : boxes)
        for (const Vec3& corner : corners) farthest = std::max(farthest, direction.dot(corner - Vec3(20, 20, 20)));
      EXPECT_GE(farthest, traced == &grid ? 7.9 : 7.0);
      EXPECT_LE(farthest, traced == &grid ? 9.8 : 8.6);
    }
    EXPECT_TRUE(traced->dataset().shown_boxes(1000).empty());
  }
}

}  // namespace
}  // namespace rhoray::tests
