#include "preprocess/position_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_THAT(names_of(mesh), ElementsAre("interior", "x", "y", "z"));
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    bool is_inside = true;
    for (const double x : mesh.points[p]) is_inside = is_inside && x > 0 && x < 1;
    EXPECT_EQ(mesh.point_fields[0].values[p], is_inside ? 1 : 0);
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(mesh.point_fields[1 + axis].values[p], mesh.points[p][axis]);
  }
  EXPECT_EQ(mesh.notes.size(), 1U);
}

TEST(PositionFields, leave_out_the_interior_of_a_mesh_that_is_all_boundary) {
  NeutralMesh mesh = tests::box_mesh({.cells = {1, 1, 1}});
  mesh.points.push_back({0.5, 0.5, 0.5});  // of no cell
  add_position_fields(mesh);
  EXPECT_THAT(names_of(mesh), ElementsAre("x", "y", "z"));
}

TEST(PositionFields, come_before_fields_that_do_not_vary) {
  NeutralMesh mesh = tests::box_mesh({.cells = {1, 1, 1}});
  EXPECT_FALSE(has_varying_field(mesh));
  mesh.cell_fields.push_back({.name = "region", .unit = {}, .values = Array<double>(mesh.cells.size(), 1)});
  mesh.point_fields.push_back(
      {.name = "flat", .unit = {}, .component_count = 2, .values = Array<double>(2 * mesh.points.size(), 3)});
  EXPECT_FALSE(has_varying_field(mesh));
  add_position_fields(mesh);
  EXPECT_THAT(names_of(mesh), ElementsAre("x", "y", "z", "flat"));
  EXPECT_TRUE(has_varying_field(mesh));
  mesh.point_fields.clear();
  mesh.cell_fields[0].values[1] = 2;
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
