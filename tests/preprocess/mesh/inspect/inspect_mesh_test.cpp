#include "preprocess/inspect_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "formats/base/error.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const Finding& found(const std::vector<Finding>& findings, const std::string& name) {
  for (const Finding& finding : findings)
    if (finding.name.find(name) != std::string::npos) return finding;
  ADD_FAILURE() << "nothing was looked for by the name " << name;
  return findings.front();
}

/// What was found, apart from what `expected` names.
void expect_only(const std::vector<Finding>& findings, const std::vector<std::string>& expected) {
  for (const Finding& finding : findings) {
    const bool is_expected = std::any_of(expected.begin(), expected.end(), [&](const std::string& name) {
      return finding.name.find(name) != std::string::npos;
    });
    EXPECT_EQ(finding.count != 0, is_expected) << finding.name << ": " << finding.count;
    EXPECT_LE(finding.first_ids.size(), 5U);
    EXPECT_TRUE(std::is_sorted(finding.first_ids.begin(), finding.first_ids.end()));
    EXPECT_FALSE(finding.packing.empty());
  }
}

NeutralMesh box() {
  return tests::box_mesh({.cells = {3, 4, 5}, .jitter = 0.1});
}

NeutralMesh two_cells() {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  mesh.cells = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  return mesh;
}

TEST(InspectMesh, finds_nothing_wrong_in_a_good_mesh) {
  NeutralMesh mesh = box();
  tests::add_point_field(mesh, "f", tests::product_field());
  const std::vector<Finding> findings = inspect_mesh(mesh);
  expect_only(findings, {});
  EXPECT_EQ(findings.size(), 15U);
}

TEST(InspectMesh, counts_what_is_wrong_with_points) {
  NeutralMesh mesh = two_cells();
  mesh.points.push_back({1, 1, 1});
  mesh.points.push_back({7, 7, 7});
  mesh.points.push_back({0, std::numeric_limits<double>::infinity(), 0});
  mesh.cells.push_back({0, 1, 2, 7});
  const std::vector<Finding> findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "at the place of another").first_ids, ElementsAre(5));
  EXPECT_THAT(found(findings, "without a cell").first_ids, ElementsAre(5, 6));
  EXPECT_THAT(found(findings, "not finite").first_ids, ElementsAre(7));
  expect_only(findings, {"at the place of another", "without a cell", "not finite"});
}

TEST(InspectMesh, counts_what_is_wrong_with_shapes_by_the_ids_of_the_source) {
  NeutralMesh mesh = two_cells();
  mesh.points.push_back({1, 0, 1});
  mesh.points.push_back({0.5, 0.5, 1e-5});
  mesh.cells = {{0, 2, 1, 3}, {0, 1, 1, 3}, {0, 1, 5, 3}, {0, 1, 2, 6}};
  mesh.cell_ids = {40, 41, 42, 43};
  const std::vector<Finding> findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "flipped").first_ids, ElementsAre(40));
  EXPECT_THAT(found(findings, "a vertex twice").first_ids, ElementsAre(41));
  EXPECT_THAT(found(findings, "flat cells").first_ids, ElementsAre(42));  // y = 0
  EXPECT_THAT(found(findings, "slivers").first_ids, ElementsAre(43));
}

TEST(InspectMesh, a_regular_tetrahedron_is_no_sliver_and_the_limit_is_one_hundredth) {
  NeutralMesh mesh;
  // Four points on a circle of radius 1, one diagonal lifted by h: R = 1 up to h^2, and r = 3 V / S
  // with V = 2 h / 3 and S = 4, the square seen from both sides.
  const auto with_height = [&](double h) {
    mesh.points = {{1, 0, 0}, {0, 1, h}, {-1, 0, 0}, {0, -1, h}};
    mesh.cells = {{0, 1, 2, 3}};
    return found(inspect_mesh(mesh), "slivers").count;
  };
  const double limit = 0.01 * 2 / 3;  // 3 r / R = 3 h / 2
  EXPECT_EQ(with_height(0.99 * limit), 1U);
  EXPECT_EQ(with_height(1.01 * limit), 0U);
  EXPECT_EQ(with_height(1), 0U);
}

TEST(InspectMesh, finds_faces_with_three_cells_and_cells_on_one_side) {
  NeutralMesh mesh = two_cells();
  mesh.points.push_back({0.5, 0.5, 0.5});
  mesh.cells.push_back({1, 2, 3, 5});  // the face of both others
  std::vector<Finding> findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "more than two cells").first_ids, ElementsAre(0));
  EXPECT_EQ(found(findings, "centre lies in another").count, 1U);  // the small one's in the larger

  mesh.cells = {{1, 2, 3, 4}, {1, 2, 3, 5}};
  findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "both cells on one side").first_ids, ElementsAre(0));
}

TEST(InspectMesh, finds_duplicated_and_overlapping_cells) {
  NeutralMesh mesh = box();
  const std::size_t cell_count = mesh.cells.size();
  auto copy = mesh.cells[7];
  std::swap(copy[0], copy[1]);
  std::swap(copy[2], copy[3]);
  mesh.cells.push_back(copy);
  std::vector<Finding> findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "given before").first_ids, ElementsAre(cell_count));
  EXPECT_EQ(found(findings, "centre lies in another").count, 0U);

  mesh = box();
  const std::size_t first = mesh.points.size();
  for (const auto& p :
       {std::array{0.3, 0.3, 0.3}, std::array{0.4, 0.3, 0.3}, std::array{0.3, 0.4, 0.3}, std::array{0.3, 0.3, 0.4}})
    mesh.points.push_back(p);
  mesh.cells.push_back({first, first + 1, first + 2, first + 3});
  findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "centre lies in another").first_ids, testing::Contains(cell_count));
}

/// One cube of six cells beside a face that is cut in two more ways.
TEST(InspectMesh, finds_points_that_hang_in_faces_of_other_cells) {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {0, 0, -2}, {1, 0, 0}};
  mesh.cells = {{0, 1, 2, 3}, {0, 2, 5, 4}, {5, 2, 1, 4}};  // the cells below part the face 0-1-2 at point 5
  const std::vector<Finding> findings = inspect_mesh(mesh);
  EXPECT_EQ(found(findings, "hangs").count, 2U);  // faces 0-1-2 and 0-1-3 of the first cell
  EXPECT_THAT(found(findings, "hangs").first_ids, ElementsAre(0));
}

TEST(InspectMesh, counts_cavities) {
  NeutralMesh mesh = tests::box_mesh({.cells = {5, 5, 5}});
  NeutralMesh hollow = mesh;
  hollow.cells.clear();
  for (const auto& cell : mesh.cells) {
    Vec3 centre(0, 0, 0);
    for (const std::uint64_t vertex : cell) centre += tests::to_vec3(mesh.points[vertex]) / 4;
    const Vec3 from_middle = centre - Vec3(0.5, 0.5, 0.5);
    const double distance = std::max({std::abs(from_middle.x), std::abs(from_middle.y), std::abs(from_middle.z)});
    if (distance > 0.1) hollow.cells.push_back(cell);
  }
  ASSERT_EQ(mesh.cells.size() - hollow.cells.size(), 6U);
  EXPECT_EQ(found(inspect_mesh(hollow), "cavities").count, 1U);
  EXPECT_EQ(found(inspect_mesh(mesh), "cavities").count, 0U);
}

TEST(InspectMesh, counts_values_that_are_not_finite_once_for_each_owner) {
  NeutralMesh mesh = two_cells();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  mesh.point_fields.push_back(
      {.name = "flow", .unit = {}, .component_count = 2, .values = {0, 1, nan, nan, 2, 3, 4, nan, 5, 6}});
  const std::vector<Finding> findings = inspect_mesh(mesh);
  EXPECT_THAT(found(findings, "'flow'").first_ids, ElementsAre(1, 3));
}

TEST(InspectMesh, refuses_a_vertex_that_is_not_there) {
  NeutralMesh mesh = two_cells();
  mesh.cells[1][2] = 5;
  try {
    inspect_mesh(mesh);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cell 1: found vertex 5"));
  }
}

NeutralVolume volume_of(const std::vector<float>& values) {
  NeutralVolume volume;
  volume.type = formats::ElementType::F32;
  volume.sample_count = {static_cast<std::int64_t>(values.size()), 1, 1};
  const auto bytes = std::as_bytes(std::span(values));
  volume.owned_samples.assign(bytes.begin(), bytes.end());
  volume.samples = volume.owned_samples;
  return volume;
}

TEST(InspectVolume, says_what_has_no_data_does_not_vary_or_looks_like_labels) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Finding> findings = inspect_volume(volume_of({1, 1, nan, 1}));
  EXPECT_THAT(found(findings, "not finite").first_ids, ElementsAre(2));
  EXPECT_EQ(found(findings, "equal samples").count, 4U);
  findings = inspect_volume(volume_of({1, 2, 3, 4}));
  expect_only(findings, {});
  NeutralVolume labels = volume_of({1});
  labels.type = formats::ElementType::U8;
  labels.sample_count = {4, 1, 1};
  EXPECT_EQ(found(inspect_volume(labels), "labels").count, 3U);  // the bytes of 1.0F: 0, 0, 128, 63
}

}  // namespace
}  // namespace rhoray::preprocess
