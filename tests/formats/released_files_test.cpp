#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"

// Files written by released versions. They stay here for ever, and every later version opens them.
namespace rhoray::formats {
namespace {

PackedFile released(const char* name) {
  return PackedFile::open(std::filesystem::path(RHORAY_RELEASED_FILES) / name);
}

template <class Reader>
void expect_sound(const Reader& read, const char* version) {
  EXPECT_EQ(read.file().version(), version);
  EXPECT_THAT(read.file().damaged_blocks(), testing::IsEmpty());
  EXPECT_THAT(deep_findings(read), testing::IsEmpty());
}

TEST(ReleasedFiles, grid_of_version_1_0_is_read) {
  const BrickGrid grid(released("1.0-grid.rho"));
  expect_sound(grid, "1.0");
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
  expect_sound(grid, "1.1");
  EXPECT_THAT(grid.file().description().required, testing::ElementsAre("axis-tables"));
  EXPECT_THAT(grid.description().axes[0], testing::ElementsAre(-2, -1, 0, 0.25, 0.5));
  EXPECT_THAT(grid.description().axes[1], testing::ElementsAre(0, 1, 3, 6));
  EXPECT_THAT(grid.description().axes[2], testing::IsEmpty());
  EXPECT_EQ(grid.samples<float>()[grid.tables().address(4, 3, 2)], 234);
}

TEST(ReleasedFiles, sparse_grid_of_version_1_1_with_two_fields_and_a_certificate_is_read) {
  const BrickGrid grid(released("1.1-sparse-grid.rho"));
  expect_sound(grid, "1.1");
  EXPECT_THAT(grid.file().description().required, testing::ElementsAre("axis-tables", "sparse-bricks"));
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
  expect_sound(mesh, "1.0");
  EXPECT_EQ(mesh.description().origin, Vec3(10, 20, 30));
  EXPECT_EQ(mesh.points().size(), 8U);
  EXPECT_EQ(mesh.description().cell_count, 6U);
  EXPECT_EQ(mesh.find_field("potential"), 0U);
  EXPECT_EQ(mesh.find_field("partial"), 1U);
  for (std::size_t p = 0; p < 8; ++p)
    EXPECT_FLOAT_EQ(mesh.values<float>(0)[p], static_cast<float>(mesh.points()[p][0] - 2 * mesh.points()[p][2]));
  EXPECT_EQ(mesh.description().fields[1].no_data_count, 1U);
  EXPECT_EQ(mesh.macro_levels<float>(0).range(1, 0, 0, 0), (Interval<float>{-2, 1}));
}

TEST(ReleasedFiles, clusters_of_version_1_2_are_read) {
  const TetMesh mesh(released("1.2-clustered-tets.rho"));
  expect_sound(mesh, "1.2");
  ASSERT_TRUE(mesh.has_clusters());
  EXPECT_EQ(mesh.clusters().cluster_count(), 3U);
  EXPECT_EQ(mesh.description().cell_count, 12U);
  EXPECT_EQ(mesh.description().dropped_cell_count, 1U);
  EXPECT_EQ(mesh.description().fields[1].no_data_count, 1U);
  std::uint64_t id_sum = 0;
  double volume = 0;
  for (std::uint64_t c = 0; c < 12; ++c) {
    id_sum += mesh.cell_id(c);
    std::array<Vec3, 4> p;
    for (std::size_t v = 0; v < 4; ++v) {
      const auto& point = mesh.points()[mesh.cell(c)[v]];
      p[v] = Vec3(point[0], point[1], point[2]);
    }
    volume += (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6;
  }
  EXPECT_EQ(id_sum, 12U * 13 / 2 - 3) << "all but cell 3";
  EXPECT_NEAR(volume, 2, 1e-12);
  for (std::size_t p = 0; p < 12; ++p) {
    const std::uint64_t rank = mesh.point_rank(p);  // x fastest
    const Vec3 world = mesh.description().origin + Vec3(mesh.points()[p][0], mesh.points()[p][1], mesh.points()[p][2]);
    EXPECT_EQ(world, Vec3(static_cast<double>(10 + rank % 3), static_cast<double>(20 + rank / 3 % 2),
                          static_cast<double>(30 + rank / 6)));
    EXPECT_FLOAT_EQ(mesh.values<float>(0)[p], static_cast<float>(world.x - 2 * world.z));
  }
  EXPECT_LE(mesh.cluster_ranges<float>(0)[0][0].hi[2], -48.0F);
}

TEST(ReleasedFiles, boundary_and_fields_of_cells_of_version_1_7_are_read) {
  const TetMesh mesh(released("1.7-tets.rho"));
  expect_sound(mesh, "1.7");
  EXPECT_EQ(mesh.boundary().size(), 6U);
  EXPECT_EQ(mesh.find_cell_field("region"), 0U);
  EXPECT_EQ(mesh.find_cell_field("stress"), 1U);
  EXPECT_EQ(mesh.find_cell_field("potential"), std::nullopt);
  EXPECT_EQ(mesh.description().cell_fields[1].type, ElementType::F64);
  for (std::uint64_t c = 0; c < 2; ++c) {
    EXPECT_EQ(mesh.cell_values<float>(0)[c], mesh.cell_id(c) == 0 ? 7 : 9);
    EXPECT_EQ(mesh.cell_values<double>(1)[c], mesh.cell_id(c) == 0 ? 0.1 : -2.5);
  }
}

TEST(ReleasedFiles, isosurface_area_and_gradient_of_version_1_8_are_read) {
  const BrickGrid grid(released("1.8-grid.rho"));
  expect_sound(grid, "1.8");
  const FieldSummary& field = grid.description().fields[0];
  ASSERT_EQ(field.isosurface_area.size(), field.histogram.size());
  ASSERT_EQ(field.mean_gradient.size(), field.histogram.size());
  // The field is 10 x in a box of 5 x 4 across x. The estimates are for surfaces of every
  // direction: of one across x they make the area 2/3, and the gradient 3/2.
  for (const double area : field.isosurface_area) EXPECT_NEAR(area, 20 / 1.5, 0.01);
  for (const double gradient : field.mean_gradient) EXPECT_NEAR(gradient, 10 * 1.5, 0.01);
}

TEST(ReleasedFiles, surface_of_version_1_3_is_read) {
  const TriangleMesh surface(released("1.3-surface.rho"));
  expect_sound(surface, "1.3");
  const TriangleMeshDescription& d = surface.description();
  EXPECT_EQ(d.point_type, ElementType::F32);
  EXPECT_EQ(d.point_count, 5U);
  EXPECT_EQ(d.bounds, Box3(Vec3(0, 0, 0), Vec3(2, 1, 4)));
  EXPECT_EQ(d.dropped_facet_count, 1U);
  EXPECT_EQ(d.unused_point_count, 1U);
  EXPECT_EQ(d.provenance.source_name, "corner.ply");
  ASSERT_EQ(d.triangle_count, 4U) << "a quadrilateral and two triangles; one with a corner twice is not there";
  const std::uint64_t ids[] = {0, 0, 1, 3};
  Vec3 areas(0, 0, 0);
  for (std::uint64_t t = 0; t < 4; ++t) {
    EXPECT_EQ(surface.triangle_id(t), ids[t]);
    Vec3 p[3];
    for (std::size_t c = 0; c < 3; ++c) {
      const auto point = surface.point(surface.triangles()[t][c]);
      p[c] = Vec3(point[0], point[1], point[2]);
    }
    areas += (p[1] - p[0]).cross(p[2] - p[0]) / 2.0;
  }
  EXPECT_EQ(areas, Vec3(-2, -4, 2)) << "2 x 1 below, 2 x 4 / 2 in front, 1 x 4 / 2 to the left, as they turn";
}

TEST(ReleasedFiles, colours_of_version_1_4_are_read) {
  const ColorGrid grid(released("1.4-colors.rho"));
  EXPECT_EQ(grid.file().version(), "1.4");
  EXPECT_THAT(grid.file().damaged_blocks(), testing::IsEmpty());
  const ColorGridDescription& d = grid.description();
  EXPECT_EQ(d.layout, (BrickLayout{{5, 4, 3}, 2, {3, 2, 2}}));
  EXPECT_EQ(d.world_from_grid, (Affine{{0, 0.5, 0}, {-0.25, 0, 0}, {0, 0, 2}, {1, -2, 3.5}}));
  EXPECT_EQ(d.length_unit, "mm");
  EXPECT_TRUE(d.has_alpha());
  EXPECT_EQ(d.provenance.source_name, "photo.nrrd");
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i) {
        const std::span<const std::uint8_t> texel = grid.texels().subspan(4 * grid.tables().address(i, j, k), 4);
        ASSERT_THAT(texel, testing::ElementsAre(10 * i, 100 + j, 200 + k, 255 - i - j - k));
      }
}

TEST(ReleasedFiles, grid_of_version_1_5_with_a_request_and_its_coverage_is_read) {
  const BrickGrid grid(released("1.5-certified-grid.rho"));
  expect_sound(grid, "1.5");
  const GridDescription& d = grid.description();
  EXPECT_EQ(d.layout, BrickLayout::sparse({8, 8, 8}, 1, 8));
  EXPECT_EQ(d.fields[0].name, "height");
  EXPECT_EQ(d.provenance.source_name, "cube.vtk");
  ASSERT_EQ(d.certificates.size(), 1U);
  const Certificate& certificate = d.certificates.at(0);
  EXPECT_EQ(certificate.coverage, 1);
  EXPECT_EQ(certificate.requested_error, 0.4);
  EXPECT_TRUE(certificate.meets_request());
  EXPECT_EQ(certificate.point_count, 343U);
  EXPECT_EQ(static_cast<double>(grid.errors<float>(0, "max")[0]), certificate.max_error);
  EXPECT_NEAR(certificate.max_error, 0.1696, 5e-5) << "as it was printed";
}

}  // namespace
}  // namespace rhoray::formats
