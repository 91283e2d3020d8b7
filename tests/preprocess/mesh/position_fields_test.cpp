#include "preprocess/mesh/position_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "preprocess/mesh/boundary_distance.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using testing::ElementsAre;

std::vector<std::string> names_of(const NeutralMesh& mesh) {
  std::vector<std::string> names;
  for (const NeutralField& field : mesh.point_fields) names.push_back(field.name);
  return names;
}

TEST(PositionFields, say_what_lies_inside_and_where_points_are) {
  NeutralMesh mesh = tests::box_mesh({.cells = {3, 3, 3}});
  add_position_fields(mesh);
  EXPECT_THAT(names_of(mesh), ElementsAre("boundary_distance", "interior", "x", "y", "z"));
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    bool is_inside = true;
    for (const double x : mesh.points[p]) is_inside = is_inside && x > 0 && x < 1;
    double distance = 1;
    for (const double x : mesh.points[p]) distance = std::min({distance, x, 1 - x});
    EXPECT_NEAR(mesh.point_fields[0].values[p], distance, 1e-15);
    EXPECT_EQ(mesh.point_fields[1].values[p], is_inside ? 1 : 0);
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(mesh.point_fields[2 + axis].values[p], mesh.points[p][axis]);
  }
}

double volume_of(const NeutralMesh& mesh, const std::array<std::uint64_t, 4>& cell) {
  const Vec3 a = tests::to_vec3(mesh.points[cell[0]]);
  const auto edge = [&](std::size_t v) { return tests::to_vec3(mesh.points[cell[v]]) - a; };
  return edge(1).dot(edge(2).cross(edge(3))) / 6;
}

TEST(PositionFields, leave_no_cell_without_a_point_inside_and_keep_volumes_and_fields) {
  const NeutralMesh before = tests::box_mesh({.cells = {2, 2, 2}});
  NeutralMesh mesh = before;
  mesh.cell_fields.push_back({.name = "region", .unit = {}, .values = Array<double>(mesh.cells.size(), 1)});
  mesh.cell_fields[0].values[5] = 7;
  mesh.point_fields.push_back({.name = "flat", .unit = {}, .values = Array<double>(mesh.points.size(), 3)});
  add_position_fields(mesh);
  ASSERT_GT(mesh.cells.size(), before.cells.size());
  ASSERT_EQ(mesh.cell_ids.size(), mesh.cells.size());
  ASSERT_EQ(mesh.cell_fields[0].values.size(), mesh.cells.size());
  std::vector<double> volumes(before.cells.size(), 0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto& cell = mesh.cells[c];
    EXPECT_TRUE(std::any_of(cell.begin(), cell.end(), [&](auto v) { return mesh.point_fields[0].values[v] > 0; }));
    EXPECT_GT(volume_of(mesh, cell), 0) << "turned over";
    volumes[mesh.cell_ids[c]] += volume_of(mesh, cell);
    EXPECT_EQ(mesh.cell_fields[0].values[c], mesh.cell_ids[c] == 5 ? 7 : 1);
  }
  for (std::size_t c = 0; c < volumes.size(); ++c) EXPECT_NEAR(volumes[c], volume_of(before, before.cells[c]), 1e-15);
  for (const NeutralField& field : mesh.point_fields) EXPECT_EQ(field.values.size(), mesh.points.size());
  EXPECT_EQ(mesh.point_fields.back().values.back(), 3);
  ASSERT_EQ(mesh.notes.size(), 2U);
  EXPECT_THAT(mesh.notes[1], testing::HasSubstr("split in four"));
}

/// By another road than the regions of a triangle: the smallest distance over a fine net of its
/// points, from above.
double distance_by_net(const std::array<double, 3>& p, const std::array<std::array<double, 3>, 3>& t) {
  constexpr int steps = 200;
  double nearest = 1e300;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j) {
      const double u = double(i) / steps, v = double(j) / steps;
      double sum = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double d = p[axis] - ((1 - u - v) * t[0][axis] + u * t[1][axis] + v * t[2][axis]);
        sum += d * d;
      }
      nearest = std::min(nearest, std::sqrt(sum));
    }
  return nearest;
}

TEST(PositionFields, the_distance_to_triangles_is_the_one_that_a_fine_net_of_their_points_finds) {
  std::mt19937 random(19);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<std::array<double, 3>> points(39 + 60);
  for (auto& p : points)
    for (double& x : p) x = coordinate(random);
  std::vector<std::array<std::uint64_t, 3>> triangles;
  for (std::uint64_t i = 0; i < 39; i += 3) triangles.push_back({i, i + 1, i + 2});
  const Array<double> distances = distances_to(triangles, points);
  for (std::size_t p = 0; p < 39; ++p) EXPECT_EQ(distances[p], 0);
  for (std::size_t p = 39; p < points.size(); ++p) {
    double nearest = 1e300;
    for (const auto& t : triangles)
      nearest = std::min(nearest, distance_by_net(points[p], {points[t[0]], points[t[1]], points[t[2]]}));
    EXPECT_LE(distances[p], nearest + 1e-12) << p;
    EXPECT_GE(distances[p], nearest - 0.005) << p << ": the net's points are at most 0.005 from any point between";
  }
}

TEST(PositionFields, a_triangle_without_area_is_as_far_as_its_edges) {
  const std::vector<std::array<double, 3>> points{{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1.5, 3, 4}, {5, 4, 0}};
  const Array<double> distances = distances_to(std::vector<std::array<std::uint64_t, 3>>{{0, 1, 2}, {1, 1, 1}}, points);
  EXPECT_NEAR(distances[3], 5, 1e-14);
  EXPECT_NEAR(distances[4], 5, 1e-14);
}

// Products of four lengths overflowed or underflowed, and another region of the triangle was
// taken for the nearest.
TEST(PositionFields, the_distance_to_triangles_scales_with_the_mesh_without_changing_a_digit) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.1});
  const auto scaled = [&](int exponent) {
    NeutralMesh copy = mesh;
    for (auto& p : copy.points)
      for (double& x : p) x = std::ldexp(x, exponent);
    add_position_fields(copy);
    return copy;
  };
  const NeutralMesh usual = scaled(0);
  for (const int exponent : {-1000, -280, -20, 20, 280, 1000}) {
    const NeutralMesh other = scaled(exponent);
    ASSERT_EQ(other.points.size(), usual.points.size());
    for (std::size_t p = 0; p < usual.points.size(); ++p) {
      EXPECT_EQ(other.point_fields[0].values[p], std::ldexp(usual.point_fields[0].values[p], exponent)) << exponent;
      EXPECT_EQ(other.point_fields[1].values[p], usual.point_fields[1].values[p]) << exponent;
    }
  }
}

TEST(PositionFields, come_before_fields_that_do_not_vary) {
  NeutralMesh mesh = tests::box_mesh({.cells = {1, 1, 1}});
  EXPECT_FALSE(has_varying_field(mesh));
  mesh.cell_fields.push_back({.name = "region", .unit = {}, .values = Array<double>(mesh.cells.size(), 1)});
  mesh.point_fields.push_back(
      {.name = "flat", .unit = {}, .component_count = 2, .values = Array<double>(2 * mesh.points.size(), 3)});
  EXPECT_FALSE(has_varying_field(mesh));
  add_position_fields(mesh);
  EXPECT_THAT(names_of(mesh), ElementsAre("boundary_distance", "interior", "x", "y", "z", "flat"));
  EXPECT_TRUE(has_varying_field(mesh));
  mesh.point_fields.clear();
  mesh.cell_fields[0].values[1] = 2;
  EXPECT_FALSE(has_varying_field(mesh)) << "numbers of regions show no shape";
  for (const char* name : {"block", "physical", "entity"}) {
    mesh.cell_fields[0].name = name;
    EXPECT_FALSE(has_varying_field(mesh)) << name;
  }
  mesh.cell_fields[0].name = "load";
  EXPECT_TRUE(has_varying_field(mesh));
}

TEST(PositionFields, a_vector_whose_components_differ_does_not_vary_for_that) {
  NeutralMesh mesh = tests::box_mesh({.cells = {1, 1, 1}});
  NeutralField flow{.name = "flow", .unit = {}, .component_count = 2, .values = {}};
  for (std::size_t p = 0; p < mesh.points.size(); ++p) flow.values.insert(flow.values.end(), {1, 2});
  mesh.point_fields.push_back(flow);
  EXPECT_FALSE(has_varying_field(mesh));
}

}  // namespace
}  // namespace rhoray::preprocess
