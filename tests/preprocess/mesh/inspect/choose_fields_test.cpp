#include "preprocess/mesh/inspect/choose_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Two cells on the face 0, 1, 2: apex 3 at height 1, apex 4 at height -3 (three times the volume);
/// point 5 is unused.
NeutralMesh two_cells() {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -3}, {7, 7, 7}};
  mesh.cells = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  return mesh;
}

NeutralField field_of(std::string name, int components, Array<double> values, bool single = false) {
  NeutralField field;
  field.name = std::move(name);
  field.unit = "mV";
  field.component_count = components;
  field.was_single_precision = single;
  field.values = std::move(values);
  return field;
}

NeutralMesh mesh_with_fields() {
  NeutralMesh mesh = two_cells();
  mesh.point_fields.push_back(field_of("voltage", 1, {0, 1, 2, 3, 4, 5}, true));
  mesh.point_fields.push_back(field_of("Momentum", 3, {1, 0, 0, 0, 2, 0, 0, 0, 3, 3, 4, 0, -6, 0, 8, 9, 9, 9}));
  mesh.point_fields.push_back(field_of("stress.max", 1, {6, 5, 4, 3, 2, 1}));
  mesh.cell_fields.push_back(field_of("tissue", 1, {10, 20}, true));
  return mesh;
}

ChosenFields all_chosen(const NeutralMesh& mesh, const std::vector<std::string>& wanted, bool cells_to_points = false) {
  std::vector<std::string> notes;
  return choose_fields(mesh, clean_mesh(mesh, "mesh"), wanted, cells_to_points, "torso.vtu", notes);
}

/// The chosen fields of points.
std::vector<ScalarField> chosen(const NeutralMesh& mesh, const std::vector<std::string>& wanted,
                                bool cells_to_points = false) {
  return all_chosen(mesh, wanted, cells_to_points).of_points;
}

std::vector<double> values_of(const ScalarField& field) {
  return std::visit([](const auto& values) { return std::vector<double>(values.begin(), values.end()); }, field.values);
}

std::vector<std::string> names_of(const std::vector<ScalarField>& fields) {
  std::vector<std::string> names;
  for (const ScalarField& field : fields) names.push_back(field.name);
  return names;
}

Error refusal(const NeutralMesh& mesh, const std::vector<std::string>& wanted, bool cells_to_points = false) {
  try {
    chosen(mesh, wanted, cells_to_points);
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorCode::internal, "accepted");
}

TEST(ChooseFields, puts_constants_ids_and_masks_last) {
  NeutralMesh mesh = two_cells();
  for (const char* name : {"IBlank", "vtkOriginalPointIds", "Global Node_Id", "node", "even"})
    mesh.point_fields.push_back(field_of(name, 1, {nan, 1, 2, 3, 4, 5}));
  mesh.point_fields.push_back(field_of("constant", 1, {nan, 1, 1, 1, 1, 1}));
  mesh.point_fields.push_back(field_of("late", 1, {0, 0, 0, 0, 1, 0}));
  mesh.cell_fields.push_back(field_of("CellId", 1, {0, 1}));
  mesh.cell_fields.push_back(field_of("stress", 1, {5, 7}));
  const ChosenFields fields = all_chosen(mesh, {});
  EXPECT_THAT(names_of(fields.of_points),
              ElementsAre("node", "even", "late", "IBlank", "vtkOriginalPointIds", "Global Node_Id", "constant"));
  EXPECT_THAT(names_of(fields.of_cells), ElementsAre("stress", "CellId"));
  EXPECT_THAT(names_of(chosen(mesh, {"IBlank", "node"})), ElementsAre("IBlank", "node"));
}

TEST(ChooseFields, takes_scalars_and_magnitudes_of_vectors_by_default) {
  const auto fields = chosen(mesh_with_fields(), {});
  EXPECT_THAT(names_of(fields), ElementsAre("voltage", "Momentum.mag", "stress.max"));
  EXPECT_THAT(values_of(fields[0]), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(values_of(fields[1]), ElementsAre(1, 2, 3, 5, 10));
  EXPECT_EQ(fields[0].unit, "mV");
  EXPECT_THAT(names_of(chosen(mesh_with_fields(), {}, true)),
              ElementsAre("voltage", "Momentum.mag", "stress.max", "tissue"));
}

TEST(ChooseFields, takes_components_by_letter_in_the_order_asked) {
  const auto fields = chosen(mesh_with_fields(), {"Momentum.z", "stress.max", "Momentum.x"});
  EXPECT_THAT(names_of(fields), ElementsAre("Momentum.z", "stress.max", "Momentum.x"));
  EXPECT_THAT(values_of(fields[0]), ElementsAre(0, 0, 3, 0, 8));
  EXPECT_THAT(values_of(fields[2]), ElementsAre(1, 0, 0, 3, -6));
}

TEST(ChooseFields, takes_tensors_by_the_same_rule_as_vectors) {
  NeutralMesh mesh = two_cells();
  Array<double> values, symmetric;
  for (int i = 0; i < 6 * 9; ++i) values.push_back(i);
  for (int i = 0; i < 6; ++i) symmetric.insert(symmetric.end(), {1, 2, 2, 2, 0, 2});
  mesh.point_fields.push_back(field_of("F", 9, values));
  mesh.point_fields.push_back(field_of("stress", 6, symmetric));
  EXPECT_THAT(names_of(chosen(mesh, {})), ElementsAre("F.mag", "stress.mag"));
  EXPECT_THAT(values_of(chosen(mesh, {"F.zz"}).at(0)), ElementsAre(8, 17, 26, 35, 44));
  EXPECT_THAT(values_of(chosen(mesh, {"F.yx"}).at(0)), ElementsAre(3, 12, 21, 30, 39));
  EXPECT_THAT(values_of(chosen(mesh, {"stress.mag"}).at(0)), Each(5)) << "1 + 4 + 4 + 2 (4 + 0 + 4)";
  EXPECT_THAT(values_of(chosen(mesh, {"stress.yz"}).at(0)), Each(0));
  EXPECT_THAT(refusal(mesh, {"F.8"}).what(), HasSubstr("no field \"F.8\""));
  EXPECT_THAT(refusal(mesh, {"F.x"}).what(), HasSubstr("no field \"F.x\""));
}

TEST(ChooseFields, says_when_the_first_field_is_a_magnitude) {
  NeutralMesh mesh = two_cells();
  mesh.point_fields.push_back(field_of("flow", 2, {3, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  mesh.point_fields.push_back(field_of("voltage", 1, {0, 1, 2, 3, 4, 5}));
  std::vector<std::string> notes;
  choose_fields(mesh, clean_mesh(mesh, "mesh"), {}, false, "torso.vtu", notes);
  EXPECT_THAT(notes, ElementsAre("using the magnitude of 2 components, 'flow.mag'; choose another with --field: "
                                 "flow.x, flow.y, voltage"));
  notes.clear();
  choose_fields(mesh, clean_mesh(mesh, "mesh"), {"flow.mag"}, false, "torso.vtu", notes);
  EXPECT_THAT(notes, IsEmpty());
}

TEST(ChooseFields, refuses_an_unknown_name_with_the_nearest_and_all_others) {
  const Error error = refusal(mesh_with_fields(), {"Voltge"});
  EXPECT_EQ(error.code(), ErrorCode::usage);
  EXPECT_STREQ(
      error.what(),
      "torso.vtu: no field \"Voltge\"; expected one of: voltage, Momentum.mag, Momentum.x, Momentum.y, Momentum.z, "
      "stress.max, tissue");
  EXPECT_EQ(error.hint(), "did you mean voltage?");
  EXPECT_THAT(refusal(mesh_with_fields(), {"temperature"}).hint(), IsEmpty());
}

TEST(ChooseFields, refuses_a_vector_without_component_cell_fields_alone_and_a_name_given_twice) {
  EXPECT_THAT(refusal(mesh_with_fields(), {"Momentum"}).hint(), HasSubstr("Momentum.mag"));
  EXPECT_THAT(refusal(mesh_with_fields(), {"tissue"}).what(), HasSubstr("found a value for each cell"));
  EXPECT_THAT(refusal(mesh_with_fields(), {"voltage", "voltage"}).what(), HasSubstr("given twice"));
  EXPECT_THAT(refusal(mesh_with_fields(), {"Momentum.0"}).what(), HasSubstr("no field \"Momentum.0\""))
      << "each component has one name";
}

TEST(ChooseFields, refuses_a_mesh_without_fields_and_fields_of_the_wrong_size) {
  EXPECT_EQ(refusal(two_cells(), {}).code(), ErrorCode::invalid);
  NeutralMesh mesh = two_cells();
  mesh.cell_fields.push_back(field_of("tissue", 1, {10, 20}));
  EXPECT_THAT(refusal(mesh, {}).hint(), HasSubstr("averages"));
  mesh.point_fields.push_back(field_of("voltage", 1, {0, 1, 2}));
  EXPECT_THAT(refusal(mesh, {}).what(),
              HasSubstr("field \"voltage\": found 3 values of 1 components; expected those of 6 points"));
}

TEST(ChooseFields, keeps_fields_of_cells_as_they_are) {
  NeutralMesh mesh = mesh_with_fields();
  mesh.cell_fields.push_back(field_of("flux", 2, {3, 4, 6, 8}));
  const ChosenFields fields = all_chosen(mesh, {});
  EXPECT_THAT(names_of(fields.of_points), ElementsAre("voltage", "Momentum.mag", "stress.max"));
  ASSERT_THAT(names_of(fields.of_cells), ElementsAre("tissue", "flux.mag"));
  EXPECT_THAT(values_of(fields.of_cells[0]), ElementsAre(10, 20));
  EXPECT_THAT(values_of(fields.of_cells[1]), ElementsAre(5, 10));
  EXPECT_EQ(fields.of_cells[0].unit, "mV");
  const ChosenFields wanted = all_chosen(mesh, {"flux.y", "voltage"});
  EXPECT_THAT(names_of(wanted.of_points), ElementsAre("voltage"));
  EXPECT_THAT(values_of(wanted.of_cells.at(0)), ElementsAre(4, 8));
  EXPECT_THAT(names_of(all_chosen(mesh, {"voltage"}).of_cells), IsEmpty());
}

TEST(ChooseFields, averages_cells_around_a_point_as_vtk_does) {
  const ChosenFields fields = all_chosen(mesh_with_fields(), {"tissue"}, true);
  EXPECT_THAT(values_of(fields.of_points.at(0)), ElementsAre(15, 15, 15, 10, 20));
  EXPECT_THAT(values_of(fields.of_cells.at(0)), ElementsAre(10, 20)) << "they stay beside the means";
}

TEST(ChooseFields, counts_a_cell_once_that_was_cut_into_tetrahedra) {
  NeutralMesh mesh = two_cells();
  mesh.points.push_back({1, 1, 1});  // 6
  mesh.cells = {{0, 1, 2, 3}, {1, 2, 3, 6}, {0, 2, 1, 4}};
  mesh.cell_ids = {7, 7, 9};
  mesh.cell_fields.push_back(field_of("tissue", 1, {10, 10, 40}));
  EXPECT_THAT(values_of(chosen(mesh, {"tissue"}, true).at(0)), ElementsAre(25, 25, 25, 10, 40, 10));
}

TEST(ChooseFields, says_how_means_change_the_range) {
  NeutralMesh mesh = mesh_with_fields();
  std::vector<std::string> notes;
  choose_fields(mesh, clean_mesh(mesh, "mesh"), {}, true, "torso.vtu", notes);
  EXPECT_THAT(notes, ElementsAre("field \"tissue\" was averaged to the points: 10 to 20 in cells became 10 to 20"));
}

TEST(ChooseFields, averages_only_cells_with_data_and_leaves_points_without_any_as_nan) {
  NeutralMesh mesh = two_cells();
  mesh.cell_fields.push_back(field_of("tissue", 1, {nan, 20}));
  const auto values = values_of(chosen(mesh, {"tissue"}, true).at(0));
  EXPECT_EQ(values[0], 20);
  EXPECT_TRUE(std::isnan(values[3]));
  EXPECT_EQ(values[4], 20);
}

TEST(ChooseFields, averages_flat_cells_like_others) {
  NeutralMesh mesh = two_cells();
  mesh.points.push_back({0.25, 0.25, 0});  // 6, in the plane of the face 0, 1, 2
  mesh.points.push_back({2, 2, 0});        // 7
  mesh.cells.push_back({0, 1, 2, 6});
  mesh.cells.push_back({1, 2, 6, 7});
  mesh.cell_fields.push_back(field_of("tissue", 1, {10, 20, 100, 300}));
  const auto values = values_of(chosen(mesh, {"tissue"}, true).at(0));
  EXPECT_THAT(values, ElementsAre(130.0 / 3, 107.5, 107.5, 10, 20, 200, 300));
}

TEST(ChooseFields, averages_a_constant_to_the_same_constant) {
  NeutralMesh mesh = tests::box_mesh({.jitter = 0.15});
  mesh.cell_fields.push_back(field_of("c", 1, Array<double>(mesh.cells.size(), 0.1)));
  for (const double value : values_of(chosen(mesh, {"c"}, true).at(0))) EXPECT_EQ(value, 0.1);
}

TEST(ChooseFields, stores_single_precision_only_where_no_source_value_changes) {
  const auto is_single = [](const ScalarField& field) { return std::holds_alternative<Array<float>>(field.values); };
  NeutralMesh mesh = two_cells();
  mesh.point_fields.push_back(field_of("exact", 1, {0.5, 1, 2, 3, nan, 5}, true));
  mesh.point_fields.push_back(field_of("claims", 1, {0.1, 1, 2, 3, 4, 5}, true));  // 0.1 is no float
  mesh.point_fields.push_back(field_of("double", 1, {0.5, 1, 2, 3, 4, 5}, false));
  mesh.point_fields.push_back(field_of("vector", 2, {1, 1, 1, 2, 1, 3, 1, 4, 1, 5, 0, 0}, true));
  mesh.point_fields.push_back(field_of("large", 2, Array<double>(12, 3e38), true));
  const auto fields = chosen(mesh, {});
  EXPECT_TRUE(is_single(fields[0]));
  EXPECT_FALSE(is_single(fields[1]));
  EXPECT_FALSE(is_single(fields[2]));
  EXPECT_TRUE(is_single(fields[3]));
  EXPECT_FALSE(is_single(fields[4])) << "its length 4.24e38 is beyond single precision";
  EXPECT_EQ(values_of(fields[3])[0], static_cast<double>(std::sqrt(2.0f)));
}

TEST(ChooseFields, takes_lengths_that_square_beyond_the_range_of_double) {
  NeutralMesh mesh = two_cells();
  mesh.point_fields.push_back(field_of("v", 2, {3e200, 4e200, 3e-200, 4e-200, 0, 0, nan, 1, 1, 1, 0, 0}));
  const auto values = values_of(chosen(mesh, {}).at(0));
  EXPECT_THAT(values[0], DoubleNear(5e200, 1e185));
  EXPECT_THAT(values[1], DoubleNear(5e-200, 1e-215));
  EXPECT_EQ(values[2], 0);
  EXPECT_TRUE(std::isnan(values[3]));
}

TEST(ChooseFields, renames_a_cell_field_with_the_name_of_a_point_field) {
  NeutralMesh mesh = mesh_with_fields();
  mesh.cell_fields.push_back(field_of("voltage", 1, {1, 2}));
  mesh.cell_fields.push_back(field_of("tissue", 1, {3, 4}));
  std::vector<std::string> notes;
  const ChosenFields fields = choose_fields(mesh, clean_mesh(mesh, "mesh"), {}, false, "torso.vtu", notes);
  EXPECT_THAT(values_of(fields.of_points.at(0)), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(names_of(fields.of_cells), ElementsAre("tissue", "voltage.cells"));
  EXPECT_THAT(values_of(fields.of_cells.at(1)), ElementsAre(1, 2));
  EXPECT_THAT(notes, ElementsAre("field \"voltage\" of cells is kept as \"voltage.cells\", because a field of points "
                                 "has its name",
                                 "field \"tissue\" of cells has the name of an earlier field; it is left out"));
}

}  // namespace
}  // namespace rhoray::preprocess
