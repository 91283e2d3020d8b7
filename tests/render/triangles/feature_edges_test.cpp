#include "render/triangles/feature_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/base/error.h"
#include "preprocess/pack_surface.h"
#include "tests/agreement/pictures.h"
#include "tests/support/expect_error.h"
#include "tests/support/surfaces.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using render::FeatureEdges;

/// A packed surface, opened for rendering.
struct Packed {
  TemporaryFolder folder;
  render::Dataset dataset;

  explicit Packed(const preprocess::NeutralSurface& surface) : dataset(packed(surface)) {}

  render::Dataset packed(const preprocess::NeutralSurface& surface) const {
    preprocess::pack_surface(surface, folder / "surface.rho");
    return render::Dataset::load(folder / "surface.rho");
  }
};

/// Two triangles at the edge from (0, 0, 0) to (0, 1, 0), bent by an angle there.
preprocess::NeutralSurface bent(double angle_deg, bool is_turned) {
  const double angle = angle_deg * std::numbers::pi / 180;
  std::vector<std::vector<std::uint64_t>> facets{{0, 1, 2}, {1, 0, 3}};
  if (is_turned) facets[1] = {0, 1, 3};
  return surface_of({{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {std::cos(angle), 0, std::sin(angle)}}, facets);
}

double length_of(const FeatureEdges& found) {
  double length = 0;
  for (const auto& [a, b] : found.edges) length += (b - a).length();
  return length;
}

TEST(FeatureEdges, are_those_that_turn_by_more_than_the_angle) {
  // The four outer edges belong to one triangle each, which counts as 180 degrees.
  for (const bool is_turned : {false, true})
    for (const double angle : {0.0, 10.0, 29.0, 31.0, 90.0, 150.0}) {
      const Packed packed(bent(angle, is_turned));
      EXPECT_EQ(packed.dataset.feature_edges(30).edges.size(), angle > 30 ? 5U : 4U) << angle;
      EXPECT_EQ(packed.dataset.feature_edges(angle + 1).edges.size(), 4U) << angle;
      EXPECT_EQ(packed.dataset.feature_edges(180).edges.size(), 0U);
    }
}

TEST(FeatureEdges, of_a_cube_are_its_twelve_edges_in_world_axes) {
  const Packed cube(cube_surface());
  const FeatureEdges found = cube.dataset.feature_edges(30);
  ASSERT_EQ(found.edges.size(), 12U);
  EXPECT_DOUBLE_EQ(found.mean_distance, 6.0 / 12.0);  // area over length
  for (const auto& [a, b] : found.edges) {
    EXPECT_DOUBLE_EQ((b - a).length(), 1);
    for (const Vec3& end : {a, b})
      for (int axis = 0; axis < 3; ++axis) EXPECT_TRUE(end[axis] == 0 || end[axis] == 1) << end;
  }
  EXPECT_EQ(cube.dataset.feature_edges(90).edges.size(), 0U);
}

TEST(FeatureEdges, of_the_boundary_of_a_mesh_far_from_the_origin_are_its_boxs_edges) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({.cells = {5, 4, 3}, .box = {{1e6, -2, 3}, {1e6 + 2, 0, 4}}});
  add_point_field(mesh, "z", [](const Vec3& p) { return p.z; });
  const render::Dataset boundary = packed(folder, "m.rho", mesh).boundary();
  const FeatureEdges found = boundary.feature_edges(30);
  EXPECT_EQ(found.edges.size(), 4U * (5 + 4 + 3));
  EXPECT_NEAR(length_of(found), 4 * (2 + 2 + 1), 1e-8);
  for (const auto& [a, b] : found.edges) {
    int on_sides = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_low = a[axis] == boundary.bounds().min[axis] && b[axis] == a[axis];
      const bool is_high = a[axis] == boundary.bounds().max[axis] && b[axis] == a[axis];
      on_sides += is_low || is_high ? 1 : 0;
    }
    EXPECT_EQ(on_sides, 2) << "an edge of the box lies in two of its sides";
  }
}

TEST(FeatureEdges, of_a_fine_ball_are_none_and_the_same_for_any_number_of_threads) {
  EXPECT_EQ(Packed(round_surface(5)).dataset.feature_edges(30).edges.size(), 0U);
  const Packed rough(round_surface(5, [](const Vec3& p) { return 1 + 0.02 * std::sin(40 * p.x); }));
  const FeatureEdges one = rough.dataset.feature_edges(15, 1), many = rough.dataset.feature_edges(15, 4);
  EXPECT_GT(one.edges.size(), 100U);
  EXPECT_EQ(one.edges, many.edges);
}

TEST(FeatureEdges, of_three_triangles_at_an_edge_count_as_180_degrees) {
  const Packed fan(
      surface_of({{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}, {0, 0, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
  EXPECT_EQ(fan.dataset.feature_edges(179).edges.size(), 7U);
}

TEST(FeatureEdges, are_refused_for_data_without_triangles) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh of_tets = box_mesh({});
  add_point_field(of_tets, "z", [](const Vec3& p) { return p.z; });
  const render::Dataset mesh = packed(folder, "m.rho", of_tets);
  expect_error(ErrorCode::usage, "is no surface and has no edges", [&] { mesh.feature_edges(30); });
}

}  // namespace
}  // namespace rhoray::tests
