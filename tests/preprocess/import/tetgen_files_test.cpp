#include "preprocess/import/readers.h"
#include "tests/preprocess/import/node_places.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

const std::string nodes =
    "# points\n5 3 2 1\n1 0 0 0  0.5 7 1\n2 1 0 0  1.5 7 1\n3 0 1 0  2.5 7 0\n\n4 0 0 1  3.5 7 0 # the top\n5 1 1 1  "
    "4.1 7 0\n";
const std::string elements = "2  4  1\n1  1 2 3 4  10\n2  2 3 4 5  20\n# end\n";

TEST(TetgenMesh, reads_points_cells_and_attributes_numbered_from_one) {
  TemporaryFolder folder;
  write_file(folder / "a.node", nodes);
  write_file(folder / "a.ele", elements);
  for (const char* name : {"a.node", "a.ele"}) {
    const NeutralMesh mesh = read_mesh(folder / name);
    EXPECT_EQ(mesh.points.size(), 5U);
    EXPECT_EQ(mesh.points[3], (std::array{0.0, 0.0, 1.0}));
    EXPECT_THAT(mesh.cells, testing::ElementsAre(std::array<std::uint64_t, 4>{0, 1, 2, 3},
                                                 std::array<std::uint64_t, 4>{1, 2, 3, 4}));
    ASSERT_EQ(mesh.point_fields.size(), 2U);
    EXPECT_EQ(mesh.point_fields[0].name, "attribute_1");
    EXPECT_THAT(mesh.point_fields[0].values, testing::ElementsAre(0.5, 1.5, 2.5, 3.5, 4.1));
    EXPECT_FALSE(mesh.point_fields[0].was_single_precision);
    EXPECT_TRUE(mesh.point_fields[1].was_single_precision);
    EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(10, 20));
  }
}

TEST(TetgenMesh, notes_lines_after_the_last_point_and_tetrahedron) {
  TemporaryFolder folder;
  write_file(folder / "a.node", nodes + "6 2 2 2 4.1 7 0\n");
  write_file(folder / "a.ele", elements + "3 2 3 4 5 20\n4 2 3 4 5 20\n");
  EXPECT_THAT(read_mesh(folder / "a.ele").notes,
              testing::ElementsAre("a.node: 1 line after the points was left out",
                                   "a.ele: 2 lines after the tetrahedra were left out"));
}

TEST(TetgenMesh, reads_numbers_from_zero) {
  TemporaryFolder folder;
  write_file(folder / "a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
  write_file(folder / "a.ele", "1 4 0\n0 3 2 1 0\n");
  EXPECT_EQ(read_mesh(folder / "a.ele").cells[0], (std::array<std::uint64_t, 4>{3, 2, 1, 0}));
}

TEST(TetgenMesh, points_alone_are_refused_with_the_surface_beside_them) {
  TemporaryFolder folder;
  write_file(folder / "a.node", nodes);
  expect_refusal([&] { read_mesh(folder / "a.node"); }, ErrorCode::unreadable, {"points alone", "a.ele"});
  write_file(folder / "a.face", "1 0\n1 1 2 3\n");
  try {
    read_mesh(folder / "a.node");
    ADD_FAILURE() << "points without tetrahedra were read";
  } catch (const Error& error) {
    EXPECT_THAT(error.hint(), testing::HasSubstr("a.face"));
  }
}

TEST(TetgenMesh, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](std::string node_text, std::string element_text, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    write_file(folder / "a.node", node_text);
    write_file(folder / "a.ele", element_text);
    expect_refusal([&] { read_mesh(folder / "a.node"); }, error_code, words);
  };
  refuses(nodes, "1 8 0\n1 1 2 3 4 5 1 2 3\n", ErrorCode::unsupported, {"a.ele, line 1", "1 elements with 8 points"});
  refuses(nodes, "1 4 0\n1 1 2 3 6\n", ErrorCode::invalid, {"a.ele, line 2", "'6'", "1 to 5"});
  refuses(nodes, "1 4 0\n1 0 2 3 4\n", ErrorCode::invalid, {"a.ele, line 2", "'0'"});
  refuses(nodes, "1 4 0\n2 1 2 3 4\n", ErrorCode::invalid, {"a.ele, line 2", "'2'"});
  refuses(nodes, "2 4 0\n1 1 2 3 4\n", ErrorCode::invalid, {"a.ele", "end of the file"});
  refuses(nodes, "0 4 0\n", ErrorCode::invalid, {"a.ele, line 1"});
  refuses(nodes, "1000000000 4 0\n1 1 2 3 4\n", ErrorCode::invalid, {"1000000000 records"});
  refuses(nodes, "1 4 1\n1 1 2 3 4\n", ErrorCode::invalid, {"a.ele, line 2", "attributes"});
  refuses("4 2 0 0\n1 0 0\n", elements, ErrorCode::unsupported, {"a.node, line 1", "3 dimensions"});
  refuses("2 3 0 0\n1 0 0 0\n3 0 0 1\n", elements, ErrorCode::invalid, {"a.node, line 3", "'3'"});
  refuses("2 3 0 0\n7 0 0 0\n8 0 0 1\n", elements, ErrorCode::invalid, {"a.node, line 2", "0 or 1"});
  refuses("2 3 0 0\n1 0 zero 0\n2 0 0 1\n", elements, ErrorCode::invalid, {"a.node, line 2", "'zero'"});
  std::filesystem::remove(folder / "a.ele");
  write_file(folder / "a.node", nodes);
  expect_refusal([&] { read_mesh(folder / "a.node"); }, ErrorCode::unreadable, {"a.ele"});
}

TEST(TetgenMesh, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const auto is_complete = [&] {
    const NeutralMesh mesh = read_mesh(folder / "a.node");
    return mesh.points[4][2] == 1 && mesh.cells.size() == 2 && mesh.cells[1][3] == 4;
  };
  write_file(folder / "a.ele", elements);
  check_every_beginning(folder / "a.node", nodes, is_complete);
  check_every_beginning(folder / "a.ele", elements, is_complete);
}

/// One tetrahedron with middle nodes, by the edges that the file gives them in this order.
void write_quadratic(TemporaryFolder& folder, const std::vector<std::pair<int, int>>& edges, double shift = 0) {
  const double corners[4][3] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  std::string text = "10 3 0 0\n";
  for (int i = 0; i < 4; ++i) text += concat(i, " ", corners[i][0], " ", corners[i][1], " ", corners[i][2], "\n");
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = edges[e];
    text += concat(4 + e);
    for (std::size_t axis = 0; axis < 3; ++axis) text += concat(" ", (corners[a][axis] + corners[b][axis]) / 2 + shift);
    text += "\n";
  }
  write_file(folder / "a.node", text);
  write_file(folder / "a.ele", "1 10 1\n0 0 1 2 3 4 5 6 7 8 9 0.25\n");
}

TEST(TetgenMesh, finds_the_order_of_middle_nodes_from_where_they_lie) {
  TemporaryFolder folder;
  const std::vector<std::pair<int, int>> chaste{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}},
      tetgen{{2, 3}, {0, 3}, {0, 1}, {1, 2}, {1, 3}, {0, 2}}, other{{2, 3}, {0, 1}, {0, 3}, {0, 2}, {1, 2}, {1, 3}};
  for (const auto& [edges, name] : {std::pair{chaste, "Chaste"}, std::pair{tetgen, "TetGen 1.5"}}) {
    write_quadratic(folder, edges, 0.1);
    const CellMesh mesh = read_cells(folder / "a.ele", {});
    EXPECT_THAT(mesh.kinds, testing::ElementsAre(CellKind::quadratic_tetrahedron));
    EXPECT_EQ(expect_nodes_in_their_places(mesh, 0.06), 6U);
    EXPECT_THAT(mesh.notes, testing::ElementsAre(testing::HasSubstr(name)));
    EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(0.25));
  }
  write_quadratic(folder, other);
  expect_refusal([&] { read_cells(folder / "a.ele", {}); }, ErrorCode::invalid, {"a.ele", "edge lengths"});
}

const std::string footer = "# Created by hand\n";
const std::string binary_nodes =
    "5\t3\t1\t0\tBIN\n" +
    bytes_of_values(std::vector<double>{0, 0, 0, 9, 1, 0, 0, 8, 0, 1, 0, 7, 0, 0, 1, 6, 1, 1, 0.1, 5}) + footer;
const std::string binary_elements =
    "2\t4\t0\tBIN\n" + bytes_of_values(std::vector<std::uint32_t>{0, 1, 2, 3, 1, 2, 3, 4});

TEST(TetgenMesh, reads_the_binary_variant) {
  TemporaryFolder folder;
  write_file(folder / "a.node", binary_nodes);
  write_file(folder / "a.ele", binary_elements + footer);
  const NeutralMesh mesh = read_mesh(folder / "a.ele");
  EXPECT_EQ(mesh.points[4], (std::array{1.0, 1.0, 0.1}));
  EXPECT_THAT(mesh.point_fields[0].values, testing::ElementsAre(9, 8, 7, 6, 5));
  EXPECT_EQ(mesh.cells[1], (std::array<std::uint64_t, 4>{1, 2, 3, 4}));
  std::string with_attribute = "1 4 1 BIN\n" + bytes_of_values(std::vector<std::uint32_t>{0, 1, 2, 3}) +
                               bytes_of_values(std::vector<double>{0.5});
  write_file(folder / "a.ele", with_attribute);
  EXPECT_THAT(read_mesh(folder / "a.ele").cell_fields[0].values, testing::ElementsAre(0.5));
}

TEST(TetgenMesh, refuses_every_beginning_of_the_binary_variant) {
  TemporaryFolder folder;
  const auto is_complete = [&] {
    const NeutralMesh mesh = read_mesh(folder / "a.node");
    return mesh.points[4][2] == 0.1 && mesh.cells.size() == 2 && mesh.cells[1][3] == 4;
  };
  write_file(folder / "a.ele", binary_elements);
  EXPECT_EQ(check_every_beginning(folder / "a.node", binary_nodes, is_complete), static_cast<int>(footer.size()));
  EXPECT_EQ(check_every_beginning(folder / "a.ele", binary_elements, is_complete), 0);
  write_file(folder / "a.ele", binary_elements + "junk");
  expect_refusal([&] { read_mesh(folder / "a.ele"); }, ErrorCode::invalid, {"a.ele, line 1", "4 bytes behind"});
  write_file(folder / "a.ele", "1 4 0 BIN\n" + bytes_of_values(std::vector<std::uint32_t>{0, 1, 2, 5}));
  expect_refusal([&] { read_mesh(folder / "a.ele"); }, ErrorCode::invalid, {"a.ele", "point 5", "0 to 4"});
  write_file(folder / "a.ele", "4611686018427387904 4 0 BIN\n0123456789abcdef");
  expect_refusal([&] { read_mesh(folder / "a.ele"); }, ErrorCode::invalid, {"a.ele"});
}

TEST(TetgenSurface, reads_faces_in_text_and_binary_with_the_points_they_name) {
  TemporaryFolder folder;
  const Array<std::uint64_t> corners{0, 1, 3, 1, 2, 3};  // of points 1, 2, 3, 4
  const auto expect_surface = [&] {
    const NeutralSurface surface = read_surface(folder / "a.face");
    EXPECT_EQ(surface.points.size(), 4U);
    EXPECT_EQ(surface.points[0], (std::array{1.0, 0.0, 0.0}));
    EXPECT_EQ(surface.facet_corners, corners);
    EXPECT_THAT(surface.facet_offsets, testing::ElementsAre(0, 3, 6));
    EXPECT_THAT(surface.notes, testing::ElementsAre("1 point that no face uses left out"));
  };
  write_file(folder / "a.node", binary_nodes);
  write_file(folder / "a.face", "2\t0\tBIN\n" + bytes_of_values(std::vector<std::uint32_t>{1, 2, 4, 2, 3, 4}) + footer);
  expect_surface();
  const auto marked = [](std::uint32_t a, std::uint32_t b, std::uint32_t c, double marker) {
    return bytes_of_values(std::vector<std::uint32_t>{a, b, c}) + bytes_of_values(std::vector<double>{marker});
  };
  write_file(folder / "a.face", "2 1 BIN\n" + marked(1, 2, 4, 1) + marked(2, 3, 4, 1));
  expect_surface();
  write_file(folder / "a.node", nodes);  // numbered from 1
  write_file(folder / "a.face", "2 1\n1 2 3 5 -1\n2 3 4 5 -1\n");
  expect_surface();
  write_file(folder / "a.face", "2 1\n1 2 3 6 -1\n2 3 4 5 -1\n");
  expect_refusal([&] { read_surface(folder / "a.face"); }, ErrorCode::invalid, {"a.face, line 2", "'6'"});
  write_file(folder / "a.face", "0 1\n");
  expect_refusal([&] { read_surface(folder / "a.face"); }, ErrorCode::invalid, {"a.face", "no faces"});
}

const std::string poly =
    "8 3 0 0\n1 0 0 0\n2 2 0 0\n3 2 2 0\n4 0 2 0\n5 0.5 0.5 0\n6 1.5 0.5 0\n7 1.5 1.5 0\n8 0.5 1.5 0\n"
    "2 1\n2 1 9 # an outline with an opening\n4 1 2\n3 4\n4 5 6 7 8\n1 1 1 0\n1\n3 1 2 3\n"
    "1\n1 9 9 9\n2\n1 0.5 0.5 5 10 0.25\n2 1 1 1 20 -1\n";

TEST(TetgenSurface, reads_facets_with_openings_holes_and_regions) {
  TemporaryFolder folder;
  write_file(folder / "a.poly", poly);
  const NeutralSurface surface = read_surface(folder / "a.poly");
  EXPECT_EQ(surface.points.size(), 8U);
  EXPECT_THAT(surface.facet_offsets, testing::ElementsAre(0, 4, 8, 11));
  EXPECT_THAT(surface.facet_corners, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2));
  EXPECT_THAT(surface.facet_faces, testing::ElementsAre(0, 0, 1));
  ASSERT_EQ(surface.openings.size(), 1U);
  EXPECT_EQ(surface.openings[0].face, 0U);
  EXPECT_EQ(surface.openings[0].seed, (std::array{1.0, 1.0, 0.0}));
  EXPECT_THAT(surface.holes, testing::ElementsAre(std::array{9.0, 9.0, 9.0}));
  ASSERT_EQ(surface.regions.size(), 2U);
  EXPECT_EQ(surface.regions[0].seed, (std::array{0.5, 0.5, 5.0}));
  EXPECT_EQ(surface.regions[0].attribute, 10);
  EXPECT_EQ(surface.regions[0].max_volume, 0.25);
  EXPECT_EQ(surface.regions[1].max_volume, 0);
}

// The corners of a polygon begin on the line of their number. They were looked for behind it only,
// so that the last polygons of a file were refused unless enough bytes followed.
TEST(TetgenSurface, reads_polygons_on_the_last_lines_of_a_file) {
  TemporaryFolder folder;
  const std::string corners = "8 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 0 0 1\n6 1 0 1\n7 0 1 1\n8 1 1 1\n";
  const std::string quads =
      "6 0\n1 0\n4 1 3 4 2\n1 0\n4 5 6 8 7\n1 0\n4 1 2 6 5\n1 0\n4 3 7 8 4\n"
      "1 0\n4 1 5 7 3\n1 0\n4 2 4 8 6";
  for (const char* end : {"\n0\n0\n", "\n0\n", "\n", "", " # the last\n"}) {
    write_file(folder / "q.poly", corners + quads + end);
    EXPECT_EQ(read_surface(folder / "q.poly").facet_offsets.size(), 7U) << end;
  }
  const std::string tetrahedron = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
  for (const char* end : {"\n0\n0\n", "\n", ""}) {
    write_file(folder / "t.poly", tetrahedron + "4 0\n1\n3 0 2 1\n1\n3 0 1 3\n1\n3 1 2 3\n1\n3 2 0 3" + end);
    EXPECT_EQ(read_surface(folder / "t.poly").facet_offsets.size(), 5U) << end;
    write_file(folder / "t.smesh", tetrahedron + "4 0\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3" + end);
    EXPECT_EQ(read_surface(folder / "t.smesh").facet_offsets.size(), 5U) << end;
  }
  write_file(folder / "t.smesh", tetrahedron + "1 0\n9 0 2 1");
  expect_refusal([&] { read_surface(folder / "t.smesh"); }, ErrorCode::invalid, {"t.smesh, line 7", "9 records"});
}

TEST(TetgenSurface, keeps_lines_that_lie_in_a_facet) {
  TemporaryFolder folder;
  std::string text = poly;
  text.replace(text.find("4 5 6 7 8"), 9, "2 5 7");
  write_file(folder / "a.poly", text);
  EXPECT_THAT(read_surface(folder / "a.poly").facet_offsets, testing::ElementsAre(0, 4, 6, 9));
}

TEST(TetgenSurface, reads_smesh_with_points_beside_and_sizes) {
  TemporaryFolder folder;
  write_file(folder / "a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
  write_file(folder / "a.smesh", "0 3 0 0\n4 0\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n0\n0\n");
  NeutralSurface surface = read_surface(folder / "a.smesh");
  EXPECT_EQ(surface.facet_offsets.size(), 5U);
  EXPECT_TRUE(surface.facet_faces.empty());
  EXPECT_TRUE(surface.point_sizes.empty());
  write_file(folder / "sizes.mtr", "4 1\n0.1\n0.2\n0.3\n0.4\n");
  EXPECT_THAT(read_surface(folder / "a.smesh", folder / "sizes.mtr").point_sizes,
              testing::ElementsAre(0.1, 0.2, 0.3, 0.4));
  write_file(folder / "a.mtr", "4 1\n1\n1\n1\n1\n");
  EXPECT_THAT(read_surface(folder / "a.smesh").point_sizes, testing::ElementsAre(1, 1, 1, 1));
  write_file(folder / "a.mtr", "3 1\n1\n1\n1\n");
  expect_refusal([&] { read_surface(folder / "a.smesh"); }, ErrorCode::invalid, {"a.mtr, line 1", "3 points"});
  write_file(folder / "a.mtr", "4 1\n1\n1\n0\n1\n");
  expect_refusal([&] { read_surface(folder / "a.smesh"); }, ErrorCode::invalid, {"a.mtr, line 4"});
  write_file(folder / "a.mtr", "4 6\n1 1 1 1 1 1\n");
  expect_refusal([&] { read_surface(folder / "a.smesh"); }, ErrorCode::unsupported, {"a.mtr, line 1"});
  expect_refusal([&] { read_surface(folder / "a.smesh", folder / "none.mtr"); }, ErrorCode::unreadable, {"none.mtr"});
}

TEST(TetgenSurface, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    std::string text = poly;
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.poly", text);
    expect_refusal([&] { read_surface(folder / "a.poly"); }, error_code, words);
  };
  refuses("4 5 6 7 8", "4 5 6 7 9", ErrorCode::invalid, {"a.poly, line 14", "'9'"});
  refuses("3 1 2 3\n", "2 1 2\n", ErrorCode::unsupported, {"line 17", "2 corners"});
  refuses("4 5 6 7 8", "0", ErrorCode::unsupported, {"line 14", "0 corners"});
  refuses("3 1 2 3\n", "3 1 2\n", ErrorCode::invalid, {"a.poly"});
  refuses("2 1\n2 1 9", "2000000000 1\n2 1 9", ErrorCode::invalid, {"2000000000 records"});
  refuses("1 9 9 9", "1 9 9", ErrorCode::invalid, {"three coordinates"});
}

TEST(TetgenSurface, refuses_every_beginning_or_keeps_all_facets) {
  TemporaryFolder folder;
  write_file(folder / "a.poly", poly);
  const NeutralSurface whole = read_surface(folder / "a.poly");
  check_every_beginning(folder / "a.poly", poly, [&] {
    const NeutralSurface part = read_surface(folder / "a.poly");  // parts 3 and 4 may be missing
    return part.facet_corners == whole.facet_corners && part.points == whole.points;
  });
}

}  // namespace
}  // namespace rhoray::preprocess
