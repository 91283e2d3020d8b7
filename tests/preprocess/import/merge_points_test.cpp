#include "preprocess/import/mesh/merge_points.h"

#include "preprocess/import/mesh/mesh_pieces.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Points along a line; each cell is a tetrahedron or, with its kind set, whatever its nodes say.
CellMesh on_a_line(const std::vector<double>& places, const std::vector<double>& values) {
  CellMesh mesh;
  for (const double x : places) mesh.points.push_back({x, 1, 2});
  mesh.point_fields = {{"v", "mV", 1, true, Array<double>(values.begin(), values.end())}};
  return mesh;
}

void add_cell(CellMesh& mesh, CellKind kind, const std::vector<std::uint64_t>& nodes) {
  mesh.kinds.push_back(kind);
  mesh.cell_nodes.insert(mesh.cell_nodes.end(), nodes.begin(), nodes.end());
  mesh.cell_offsets.push_back(mesh.cell_nodes.size());
}

TEST(MergePoints, makes_one_point_of_those_at_the_same_place_in_different_pieces) {
  CellMesh mesh = on_a_line({0, 1, 2, 3, 3, 2, 4, -0.0}, {10, 11, 12, 13, 13, 12, 14, 10});
  mesh.point_fields.push_back({"w", "", 2, true, {0, 0, 1, 1, 2, 2, 3, 3, 3, 3, 2, 2, 4, 5, 0, 0}});
  add_cell(mesh, CellKind::tetrahedron, {0, 1, 2, 3});
  add_cell(mesh, CellKind::tetrahedron, {4, 5, 6, 7});
  merge_coincident_points(mesh, std::vector<std::uint64_t>{0, 4, 8});
  EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 2, 3, 3, 2, 4, 0));
  ASSERT_EQ(mesh.points.size(), 5U);
  EXPECT_EQ(mesh.points[4][0], 4);
  EXPECT_THAT(mesh.point_fields[0].values, ElementsAre(10, 11, 12, 13, 14));
  EXPECT_THAT(mesh.point_fields[1].values, ElementsAre(0, 0, 1, 1, 2, 2, 3, 3, 4, 5));
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("3 points merged")));
}

TEST(MergePoints, leaves_points_of_one_piece_and_near_points_apart) {
  CellMesh mesh = on_a_line({0, 0, 1, std::nextafter(1, 2), NAN, NAN}, {1, 1, 2, 2, 3, 3});
  add_cell(mesh, CellKind::tetrahedron, {0, 1, 2, 3});
  const CellMesh before = mesh;
  merge_coincident_points(mesh, std::vector<std::uint64_t>{0, 3, 5, 6});
  EXPECT_EQ(mesh.cell_nodes, before.cell_nodes);
  EXPECT_EQ(mesh.points.size(), before.points.size());
  EXPECT_TRUE(mesh.notes.empty());
  CellMesh one_piece = on_a_line({0, 0, 0}, {1, 1, 1});
  merge_coincident_points(one_piece, std::vector<std::uint64_t>{0, 3});
  EXPECT_EQ(one_piece.points.size(), 3U);
}

TEST(MergePoints, keeps_the_first_piece_s_values_and_says_where_others_differed) {
  CellMesh mesh = on_a_line({0, 1, 0, 1, 0, 1}, {1, 2, 1, 2.5, 1, 1.75});
  merge_coincident_points(mesh, std::vector<std::uint64_t>{0, 2, 4, 6});
  EXPECT_THAT(mesh.point_fields[0].values, ElementsAre(1, 2));
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("4 points merged"),
                                      HasSubstr("'v' differs at 2 of the merged points, by up to 0.5")));
}

TEST(MergePoints, takes_equal_values_as_the_guide_where_a_piece_has_several_points) {
  // A cut: both pieces have two points at 0, with values 1 and 2, in another order; a third value
  // belongs to nobody.
  CellMesh mesh = on_a_line({0, 0, 0, 0, 0}, {1, 2, 2, 1, 3});
  add_cell(mesh, CellKind::tetrahedron, {0, 1, 2, 3});
  add_cell(mesh, CellKind::tetrahedron, {4, 3, 2, 1});
  merge_coincident_points(mesh, std::vector<std::uint64_t>{0, 2, 4, 5});
  EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 1, 0, 2, 0, 1, 1));
  EXPECT_THAT(mesh.point_fields[0].values, ElementsAre(1, 2, 3));
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("2 points merged"), HasSubstr("1 point not merged")));
}

/// A search through all points at a place, quadratic in their count, would run out of the time that
/// a test has.
TEST(MergePoints, takes_time_in_proportion_to_the_points) {
  constexpr std::size_t count = 2'000'000;
  const auto left = [](CellMesh mesh) {
    merge_coincident_points(mesh, std::vector<std::uint64_t>{0, count / 2, count});
    return mesh.points.size();
  };
  const std::vector<double> not_finite(count, NAN), one_place(count, 1), same(count, 7);
  std::vector<double> all_differ(count);  // the second half has the values of the first from the end
  for (std::size_t i = 0; i < count; ++i) all_differ[i] = static_cast<double>(std::min(i, count - 1 - i));
  EXPECT_EQ(left(on_a_line(not_finite, same)), count);
  EXPECT_EQ(left(on_a_line(one_place, same)), count / 2);
  EXPECT_EQ(left(on_a_line(one_place, all_differ)), count / 2);
}

TEST(MergePoints, renumbers_the_faces_of_polyhedra_but_not_their_counts) {
  CellMesh mesh = on_a_line({5, 0, 1, 2, 0, 1, 2, 3}, {9, 0, 1, 2, 0, 1, 2, 3});
  add_cell(mesh, CellKind::tetrahedron, {0, 1, 2, 3});
  add_cell(mesh, CellKind::polyhedron, {4, 3, 4, 5, 6, 3, 4, 5, 7, 3, 5, 6, 7, 3, 6, 4, 7});
  merge_coincident_points(mesh, std::vector<std::uint64_t>{0, 4, 8});
  EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 2, 3, 4, 3, 1, 2, 3, 3, 1, 2, 4, 3, 2, 3, 4, 3, 3, 1, 4));
}

TEST(MeshPieces, number_their_cells_where_some_are_left_out) {
  constexpr std::uint64_t count = 1000;
  MeshPieces pieces;
  for (std::uint64_t p = 0; p < count; ++p) {
    const double x = static_cast<double>(2 * p);
    CellMesh mesh;
    mesh.points = {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}, {x, 0, 1}};
    ForeignCells cells{.kinds = {10, 5}, .offsets = {0, 4, 7}, .nodes = {0, 1, 2, 3, 0, 1, 2}};
    if (p == 0) cells = {.kinds = {10}, .offsets = {0, 4}, .nodes = {0, 1, 2, 3}};
    pieces.add(std::move(mesh), std::move(cells), "a.pvtu");
  }
  const CellMesh whole = pieces.finish("a.pvtu");
  ASSERT_EQ(whole.cell_ids.size(), count);
  for (std::uint64_t p = 0; p < count; ++p) ASSERT_EQ(whole.cell_ids[p], p == 0 ? 0 : 2 * p - 1);
}

}  // namespace
}  // namespace rhoray::preprocess
