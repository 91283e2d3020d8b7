#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string cube_points = "9\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n0.5 0.5 -1.5\n";

TEST(Carp, reads_cells_of_every_kind_by_either_name) {
  TemporaryFolder folder;
  write_file(folder / "a.pts", cube_points);
  write_file(folder / "a.elem",
             "6\nTt 0 1 3 4 7\nHx 0 1 2 3 4 5 6 7 8\nPr 0 1 3 4 5 7 9\nPy 0 1 2 3 8 -1\nTr 0 1 2 5\nTt 1 2 3 6\n");
  write_file(folder / "a.lon", "1\n1 0 0\n");
  for (const char* name : {"a.pts", "a.elem"}) {
    const CellMesh mesh = read_cells(folder / name, {});
    EXPECT_EQ(mesh.points.size(), 9U);
    EXPECT_EQ(mesh.points[8], (std::array{0.5, 0.5, -1.5}));
    EXPECT_THAT(mesh.kinds, ElementsAre(CellKind::tetrahedron, CellKind::hexahedron, CellKind::wedge, CellKind::pyramid,
                                        CellKind::tetrahedron));
    EXPECT_THAT(mesh.cell_nodes,
                ElementsAre(0, 1, 3, 4, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 3, 4, 5, 7, 0, 1, 2, 3, 8, 1, 2, 3, 6));
    EXPECT_THAT(mesh.cell_ids, ElementsAre(0, 1, 2, 3, 5));
    ASSERT_EQ(mesh.cell_fields.size(), 1U);
    EXPECT_EQ(mesh.cell_fields[0].name, "region");
    EXPECT_THAT(mesh.cell_fields[0].values, ElementsAre(7, 8, 9, -1, 0));
    EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("1 triangle")));
  }
}

TEST(Carp, turns_upper_nodes_that_run_the_other_way_round) {
  TemporaryFolder folder;
  write_file(folder / "a.pts", cube_points);
  write_file(folder / "a.elem", "2\nHx 0 1 2 3 4 7 6 5 1\nPr 0 1 3 4 7 5 1\n");
  const CellMesh mesh = read_cells(folder / "a.elem", {});
  EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 3, 4, 5, 7));
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("wedges: the upper nodes"), HasSubstr("hexahedra: the upper nodes")));
}

TEST(Carp, reads_tetrahedra_without_words) {
  TemporaryFolder folder;
  write_file(folder / "a.pts", cube_points);
  write_file(folder / "a.tet", "2\n0 1 3 4 5\n1 2 3 6\n");
  for (const char* name : {"a.pts", "a.tet"}) {
    const CellMesh mesh = read_cells(folder / name, {});
    EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 3, 4, 1, 2, 3, 6));
    EXPECT_THAT(mesh.cell_fields[0].values, ElementsAre(5, 0));
  }
}

TEST(Carp, notes_lines_after_the_last_point_and_cell) {
  TemporaryFolder folder;
  write_file(folder / "a.pts", cube_points + "7 7 7\n");
  write_file(folder / "a.elem", "1\nTt 0 1 3 4 7\nTt 1 2 3 6 7\nTt 1 2 3 6 7\n");
  EXPECT_THAT(read_cells(folder / "a.elem", {}).notes, ElementsAre("a.pts: 1 line after the points was left out",
                                                                   "a.elem: 2 lines after the cells were left out"));
}

TEST(Carp, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& points, const std::string& cells, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    write_file(folder / "a.pts", points);
    write_file(folder / "a.elem", cells);
    expect_refusal([&] { read_cells(folder / "a.elem", {}); }, error_code, words);
  };
  refuses("2\n0 0 0\n", "1\nTt 0 0 0 0\n", ErrorCode::invalid, {"a.pts", "2 points"});
  refuses("0 0 0\n1 0 0\n", "1\nTt 0 0 0 0\n", ErrorCode::invalid, {"a.pts, line 1", "a number of points"});
  refuses(cube_points, "2\nTt 0 1 3 4 7\n", ErrorCode::invalid, {"a.elem", "2 cells"});
  refuses(cube_points, "1\nTt 0 1 3\n", ErrorCode::invalid, {"a.elem, line 2", "a point"});
  refuses(cube_points, "1\nTt 0 1 3 9 7\n", ErrorCode::invalid, {"cell 0", "point 9"});
  refuses(cube_points, "1\nHx 0 1 2 3 4 5 6 9 7\n", ErrorCode::invalid, {"cell 0", "point 9"});
  refuses(cube_points, "1\nTt 0 1 3 -4 7\n", ErrorCode::invalid, {"a.elem, line 2", "'-4'"});
  refuses(cube_points, "1\nOc 0 1 3 4 5 6 7\n", ErrorCode::unsupported, {"a.elem, line 2", "'Oc'", "Hx"});
  refuses(cube_points, "1\nTr 0 1 3 7\n", ErrorCode::invalid, {"cells", "1 triangle"});
  refuses(cube_points, "18446744073709551615\nTt 0 1 3 4 7\n", ErrorCode::invalid, {"a.elem"});
  std::filesystem::remove(folder / "a.elem");
  expect_refusal([&] { read_cells(folder / "a.pts", {}); }, ErrorCode::unreadable, {"points alone", "a.elem or .tet"});
  write_file(folder / "b.elem", "1\nTt 0 1 3 4 7\n");
  expect_refusal([&] { read_cells(folder / "b.elem", {}); }, ErrorCode::unreadable, {"b.pts"});
}

TEST(Carp, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  write_file(folder / "a.pts", cube_points);
  const std::string cells = "2\nTt 0 1 3 4 7\nTt 1 2 3 6 8";
  const auto is_complete = [&] {
    const CellMesh mesh = read_cells(folder / "a.elem", {});
    return mesh.kinds.size() == 2 && mesh.cell_fields[0].values[0] == 7;
  };
  // Without its last region the file is whole.
  EXPECT_EQ(check_every_beginning(folder / "a.elem", cells, is_complete, {.is_text = true}), 2);
  const auto points_are_complete = [&] {
    return is_complete() && read_cells(folder / "a.elem", {}).points.size() == 9;
  };
  EXPECT_EQ(check_every_beginning(folder / "a.pts", cube_points, points_are_complete, {.is_text = true}), 1);
}

}  // namespace
}  // namespace rhoray::preprocess
