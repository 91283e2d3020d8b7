// Real files made by others; their facts stand in the README beside them. Runs where
// RHORAY_SHARED_DATA names their folder.

#include <cstdlib>

#include "formats/vdb_grid.h"
#include "preprocess/import_volume.h"
#include "preprocess/open_vdb.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

class SharedVdb : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("RHORAY_SHARED_DATA");
    if (folder == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA does not name the folder of real files";
    folder_ = std::filesystem::path(folder) / "vdb";
    ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  }
  std::filesystem::path folder_;
};

TEST_F(SharedVdb, smoke_of_an_old_version_has_its_known_voxels_place_and_range) {
  const formats::VdbGrid grid(open_vdb(folder_ / "smoke.vdb", ""));
  EXPECT_EQ(grid.description().active_voxel_count, 1049275U);
  EXPECT_EQ(grid.description().first_sample, Index3(0, 1, 0));
  EXPECT_EQ(grid.description().sample_count, Index3(113, 224, 114));
  EXPECT_NEAR(grid.description().world_from_index.x_axis.x, 0.47619, 1e-5);
  EXPECT_EQ(grid.description().field.name, "density");
  EXPECT_EQ(grid.description().field.range.lo, 0);
  EXPECT_NEAR(grid.description().field.range.hi, 5.715, 5e-4);
  EXPECT_EQ(import_volume(folder_ / "smoke.vdb").sample_count, Index3(113, 224, 114));
}

TEST_F(SharedVdb, sphere_and_points_are_what_they_are) {
  const std::vector<VdbGridFacts> sphere = inspect_vdb(folder_ / "oiio_sphere.vdb");
  ASSERT_EQ(sphere.size(), 1U);
  EXPECT_EQ(sphere[0].active_voxel_count, 9047U);
  EXPECT_EQ(sphere[0].grid_class, "fog volume");
  EXPECT_EQ(sphere[0].field->range, (Interval<double>{0, 1}));
  expect_refusal([&] { open_vdb(folder_ / "points.vdb", ""); }, ErrorCode::unsupported, {"points.vdb", "points"});
}

}  // namespace
}  // namespace rhoray::preprocess
