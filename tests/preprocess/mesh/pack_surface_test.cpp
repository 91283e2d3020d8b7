#include "preprocess/pack_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "preprocess/mesh/inspect/cut_polygon.h"
#include "tests/support/expect_error.h"
#include "tests/support/surfaces.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using tests::expect_error;
using tests::surface_of;

class PackSurface : public testing::Test {
 protected:
  formats::TriangleMesh packed(const NeutralSurface& surface) {
    report_ =
        pack_surface(surface, folder_ / "a.rho", {.command = "made", .source_name = "a.off", .replace_existing = true});
    const formats::TriangleMesh mesh(formats::PackedFile::open(folder_ / "a.rho"));
    EXPECT_THAT(formats::deep_findings(mesh), testing::IsEmpty());
    EXPECT_EQ(report_.file_bytes, mesh.file().file_bytes());
    return mesh;
  }

  tests::TemporaryFolder folder_;
  PackSurfaceReport report_;
};

TEST_F(PackSurface, keeps_triangles_as_they_are) {
  const NeutralSurface cube = tests::cube_surface();
  const formats::TriangleMesh mesh = packed(cube);
  const formats::TriangleMeshDescription& d = mesh.description();
  EXPECT_EQ(d.point_count, 8U);
  EXPECT_EQ(d.triangle_count, 12U);
  EXPECT_EQ(d.bounds, Box3(Vec3(0), Vec3(1)));
  EXPECT_EQ(d.point_type, formats::ElementType::F32);
  EXPECT_TRUE(d.has_source_order);
  EXPECT_THAT(report_.notes, testing::IsEmpty());
  EXPECT_EQ(d.provenance.source_name, "a.off");
  for (std::uint64_t t = 0; t < 12; ++t)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(mesh.point(mesh.triangles()[t][c]), cube.points[cube.facet_corners[3 * t + c]]);
}

TEST_F(PackSurface, keeps_every_bit_of_points) {
  NeutralSurface cube = tests::cube_surface();
  cube.points[7][1] = 0.1;
  const formats::TriangleMesh mesh = packed(cube);
  EXPECT_EQ(mesh.description().point_type, formats::ElementType::F64);
  for (std::uint64_t p = 0; p < 8; ++p) EXPECT_EQ(mesh.point(p), cube.points[p]);
}

TEST_F(PackSurface, cuts_squares_and_leads_back_to_them) {
  const formats::TriangleMesh mesh = packed(tests::cube_surface(false));
  EXPECT_EQ(mesh.description().triangle_count, 12U);
  for (std::uint64_t t = 0; t < 12; ++t) EXPECT_EQ(mesh.triangle_id(t), t / 2);
  EXPECT_THAT(report_.notes, testing::ElementsAre("6 facets with more than three corners cut into triangles"));
}

TEST_F(PackSurface, drops_what_is_no_triangle_and_says_so) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const NeutralSurface surface = surface_of({{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}, {2, 0, 0}},
                                            {{1, 2, 2}, {1, 2, 3}, {1, 2, 4}, {1, 2, 5}});
  const formats::TriangleMesh mesh = packed(surface);
  EXPECT_EQ(mesh.description().triangle_count, 2U);
  EXPECT_EQ(mesh.description().dropped_facet_count, 2U);
  EXPECT_EQ(mesh.description().flat_triangle_count, 1U);
  EXPECT_EQ(mesh.description().unused_point_count, 2U);
  EXPECT_EQ(mesh.triangle_id(0), 1U);
  EXPECT_EQ(mesh.triangle_id(1), 3U);
  EXPECT_THAT(report_.notes,
              testing::ElementsAre("2 facets dropped because of a repeated corner or a coordinate that is not finite",
                                   "1 triangle of zero area kept", "2 points without a triangle dropped"));
}

TEST_F(PackSurface, refuses_what_leaves_no_triangle) {
  expect_error(ErrorCode::invalid, "three different finite corners", [&] {
    packed(surface_of({{0, 0, 0}, {1, 0, 0}}, {{0, 1, 1}}));
  });
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.rho"));
}

TEST_F(PackSurface, refuses_faces_of_several_outlines) {
  NeutralSurface surface = tests::cube_surface(false);
  surface.facet_faces = {0, 0, 1, 2, 3, 4};
  expect_error(ErrorCode::unsupported, "several outlines", [&] { packed(surface); });
}

double area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * (b - a).cross(c - a).z;
}

TEST(CutPolygon, covers_polygons_that_are_not_convex_once) {
  // A comb: its fan about any corner would cover places twice.
  std::vector<Vec3> comb;
  for (int tooth = 0; tooth < 4; ++tooth) {
    comb.emplace_back(tooth, 0, 0);
    comb.emplace_back(tooth + 0.5, -3, 0);
  }
  comb.emplace_back(4, 0, 0);
  comb.emplace_back(4, 1, 0);
  comb.emplace_back(0, 1, 0);
  double expected = 0;
  for (std::size_t i = 0; i < comb.size(); ++i) expected += area(Vec3(0), comb[i], comb[(i + 1) % comb.size()]);
  for (std::size_t turn = 0; turn < comb.size(); ++turn) {
    std::rotate(comb.begin(), comb.begin() + 1, comb.end());
    const auto triangles = cut_polygon(comb);
    ASSERT_EQ(triangles.size(), comb.size() - 2);
    double sum = 0;
    for (const auto& t : triangles) {
      const double of_one = area(comb[t[0]], comb[t[1]], comb[t[2]]);
      EXPECT_GE(of_one, 0) << "turned over";
      sum += of_one;
    }
    EXPECT_NEAR(sum, expected, 1e-12);
  }
}

TEST(CutPolygon, gives_some_triangles_of_polygons_that_are_none) {
  EXPECT_EQ(cut_polygon(std::vector<Vec3>(5, Vec3(1, 2, 3))).size(), 3U);
  EXPECT_EQ(cut_polygon(std::vector<Vec3>{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2U);
}

}  // namespace
}  // namespace rhoray::preprocess
