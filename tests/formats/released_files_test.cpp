#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"

// Files that released versions wrote. They stay here for ever, and every later version opens them.
namespace rhoray::formats {
namespace {

PackedFile released(const char* name) {
  return PackedFile::open(std::filesystem::path(RHORAY_RELEASED_FILES) / name);
}

TEST(ReleasedFiles, grid_of_version_1_0_is_read) {
  const BrickGrid grid(released("1.0-grid.rho"));
  EXPECT_EQ(grid.file().version(), "1.0");
  EXPECT_THAT(grid.file().damaged_blocks(), testing::IsEmpty());
  EXPECT_THAT(deep_findings(grid), testing::IsEmpty());
  const GridDescription& d = grid.description();
  EXPECT_EQ(d.layout, (BrickLayout{{9, 6, 5}, 4, {3, 2, 2}}));
  EXPECT_EQ(d.world_from_grid, (Affine{{0, 0.5, 0}, {-0.25, 0, 0}, {0, 0, 2}, {1, -2, 3.5}}));
  EXPECT_EQ(d.length_unit, "mm");
  EXPECT_EQ(d.fields[0].name, "density");
  EXPECT_EQ(d.fields[0].unit, "HU");
  EXPECT_EQ(d.provenance.source_name, "made.nrrd");
  EXPECT_EQ(d.macro, (MacroShape{{8, 5, 4}, 2, 2}));
  const std::span<const std::int16_t> samples = grid.samples<std::int16_t>();
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 9; ++i) ASSERT_EQ(samples[grid.tables().address(i, j, k)], 300 * i - 70 * j + k);
  EXPECT_EQ(grid.macro_levels<std::int16_t>().range(2, 1, 1, 0), (Interval<std::int16_t>{850, 2124}));
}

TEST(ReleasedFiles, rectilinear_grid_of_version_1_1_is_read) {
  const BrickGrid grid(released("1.1-rectilinear-grid.rho"));
  EXPECT_EQ(grid.file().version(), "1.1");
  EXPECT_THAT(grid.file().description().required, testing::ElementsAre("axis-tables"));
  EXPECT_THAT(grid.file().damaged_blocks(), testing::IsEmpty());
  EXPECT_THAT(deep_findings(grid), testing::IsEmpty());
  EXPECT_THAT(grid.description().axes[0], testing::ElementsAre(-2, -1, 0, 0.25, 0.5));
  EXPECT_THAT(grid.description().axes[1], testing::ElementsAre(0, 1, 3, 6));
  EXPECT_THAT(grid.description().axes[2], testing::IsEmpty());
  EXPECT_EQ(grid.samples<float>()[grid.tables().address(4, 3, 2)], 234);
}

TEST(ReleasedFiles, sparse_grid_of_version_1_1_with_two_fields_and_a_certificate_is_read) {
  const BrickGrid grid(released("1.1-sparse-grid.rho"));
  EXPECT_EQ(grid.file().version(), "1.1");
  EXPECT_THAT(grid.file().description().required, testing::ElementsAre("axis-tables", "sparse-bricks"));
  EXPECT_THAT(grid.file().damaged_blocks(), testing::IsEmpty());
  EXPECT_THAT(deep_findings(grid), testing::IsEmpty());
  const GridDescription& d = grid.description();
  EXPECT_EQ(d.layout, BrickLayout::sparse({9, 6, 5}, 8, 4));
  EXPECT_THAT(d.axes[0], testing::ElementsAre(-2, -1, 0, 0.25, 0.5, 0.75, 1, 10, 1000));
  ASSERT_EQ(d.fields.size(), 2U);
  EXPECT_EQ(d.fields[1].unit, "Pa");
  EXPECT_EQ(d.certificates.at(1), (Certificate{ElementType::F32, 0.5, 0.1, {1, 2, 3}, 12345}));
  EXPECT_EQ(grid.errors<float>(1, "max")[1], 0.5F);
  const SparseAddress address(d.layout, grid.tables(), grid.brick_slots());
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 9; ++i) {
        const std::uint64_t at = address(i, j, k);
        ASSERT_EQ(at == SparseAddress::no_sample, i < 4);
        if (i < 4) continue;
        ASSERT_EQ(grid.samples<float>(0)[at], static_cast<float>(300 * i - 70 * j + k));
        ASSERT_EQ(grid.samples<float>(1)[at], -grid.samples<float>(0)[at]);
      }
}

TEST(ReleasedFiles, mesh_of_version_1_0_is_read) {
  const TetMesh mesh(released("1.0-tets.rho"));
  EXPECT_EQ(mesh.file().version(), "1.0");
  EXPECT_THAT(mesh.file().damaged_blocks(), testing::IsEmpty());
  EXPECT_THAT(deep_findings(mesh), testing::IsEmpty());
  EXPECT_EQ(mesh.description().origin, Vec3(10, 20, 30));
  EXPECT_EQ(mesh.points().size(), 8U);
  EXPECT_EQ(mesh.cells().size(), 6U);
  EXPECT_EQ(mesh.find_field("potential"), 0U);
  EXPECT_EQ(mesh.find_field("partial"), 1U);
  for (std::size_t p = 0; p < 8; ++p)
    EXPECT_FLOAT_EQ(mesh.values<float>(0)[p], static_cast<float>(mesh.points()[p][0] - 2 * mesh.points()[p][2]));
  EXPECT_EQ(mesh.description().fields[1].no_data_count, 1U);
  EXPECT_EQ(mesh.macro_levels<float>(0).range(1, 0, 0, 0), (Interval<float>{-2, 1}));
}

}  // namespace
}  // namespace rhoray::formats
