#include "preprocess/import/readers.h"
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

TEST(TetgenMesh, reads_numbers_from_zero) {
  TemporaryFolder folder;
  write_file(folder / "a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
  write_file(folder / "a.ele", "1 4 0\n0 3 2 1 0\n");
  EXPECT_EQ(read_mesh(folder / "a.ele").cells[0], (std::array<std::uint64_t, 4>{3, 2, 1, 0}));
}

TEST(TetgenMesh, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](std::string node_text, std::string element_text, Trouble trouble,
                           const std::vector<std::string>& words) {
    write_file(folder / "a.node", node_text);
    write_file(folder / "a.ele", element_text);
    expect_refusal([&] { read_mesh(folder / "a.node"); }, trouble, words);
  };
  refuses(nodes, "1 10 0\n1 1 2 3 4 5 1 2 3 4 5\n", Trouble::unsupported,
          {"a.ele, line 1", "1 tetrahedra with 10 points"});
  refuses(nodes, "1 4 0\n1 1 2 3 6\n", Trouble::invalid, {"a.ele, line 2", "'6'", "1 to 5"});
  refuses(nodes, "1 4 0\n1 0 2 3 4\n", Trouble::invalid, {"a.ele, line 2", "'0'"});
  refuses(nodes, "1 4 0\n2 1 2 3 4\n", Trouble::invalid, {"a.ele, line 2", "'2'"});
  refuses(nodes, "2 4 0\n1 1 2 3 4\n", Trouble::invalid, {"a.ele", "end of the file"});
  refuses(nodes, "0 4 0\n", Trouble::invalid, {"a.ele, line 1"});
  refuses(nodes, "1000000000 4 0\n1 1 2 3 4\n", Trouble::invalid, {"1000000000 records"});
  refuses(nodes, "1 4 1\n1 1 2 3 4\n", Trouble::invalid, {"a.ele, line 2", "attributes"});
  refuses("4 2 0 0\n1 0 0\n", elements, Trouble::unsupported, {"a.node, line 1", "3 dimensions"});
  refuses("2 3 0 0\n1 0 0 0\n3 0 0 1\n", elements, Trouble::invalid, {"a.node, line 3", "'3'"});
  refuses("2 3 0 0\n7 0 0 0\n8 0 0 1\n", elements, Trouble::invalid, {"a.node, line 2", "0 or 1"});
  refuses("2 3 0 0\n1 0 zero 0\n2 0 0 1\n", elements, Trouble::invalid, {"a.node, line 2", "'zero'"});
  refuses("20118 3 0 0 BIN\n\x01\x02", elements, Trouble::unsupported, {"a.node, line 1", "binary"});
  std::filesystem::remove(folder / "a.ele");
  write_file(folder / "a.node", nodes);
  expect_refusal([&] { read_mesh(folder / "a.node"); }, Trouble::unreadable, {"a.ele"});
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
  expect_refusal([&] { read_surface(folder / "a.smesh"); }, Trouble::invalid, {"a.mtr, line 1", "3 points"});
  write_file(folder / "a.mtr", "4 1\n1\n1\n0\n1\n");
  expect_refusal([&] { read_surface(folder / "a.smesh"); }, Trouble::invalid, {"a.mtr, line 4"});
  write_file(folder / "a.mtr", "4 6\n1 1 1 1 1 1\n");
  expect_refusal([&] { read_surface(folder / "a.smesh"); }, Trouble::unsupported, {"a.mtr, line 1"});
  expect_refusal([&] { read_surface(folder / "a.smesh", folder / "none.mtr"); }, Trouble::unreadable, {"none.mtr"});
}

TEST(TetgenSurface, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, Trouble trouble,
                           const std::vector<std::string>& words) {
    std::string text = poly;
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.poly", text);
    expect_refusal([&] { read_surface(folder / "a.poly"); }, trouble, words);
  };
  refuses("4 5 6 7 8", "4 5 6 7 9", Trouble::invalid, {"a.poly, line 14", "'9'"});
  refuses("3 1 2 3\n", "2 1 2\n", Trouble::unsupported, {"line 17", "2 corners"});
  refuses("4 5 6 7 8", "0", Trouble::unsupported, {"line 14", "0 corners"});
  refuses("3 1 2 3\n", "3 1 2\n", Trouble::invalid, {"a.poly"});
  refuses("2 1\n2 1 9", "2000000000 1\n2 1 9", Trouble::invalid, {"2000000000 records"});
  refuses("1 9 9 9", "1 9 9", Trouble::invalid, {"three coordinates"});
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
