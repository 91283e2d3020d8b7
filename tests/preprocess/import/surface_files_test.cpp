#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPolyData.h>
#include <vtkSTLWriter.h>
#include <zlib.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

/// A tetrahedron's four faces; point 3 has a coordinate that only a double holds.
const Array<std::array<double, 3>> tetrahedron_points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.25, 1}};
const Array<std::uint64_t> tetrahedron_corners{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

bool is_tetrahedron(const NeutralSurface& surface) {
  return surface.points == tetrahedron_points && surface.facet_corners == tetrahedron_corners &&
         surface.facet_offsets == Array<std::uint64_t>{0, 3, 6, 9, 12};
}

/// In STL points are numbered as they are met.
bool is_tetrahedron_in_any_order(const NeutralSurface& surface) {
  if (surface.points.size() != 4 || surface.facet_corners.size() != 12) return false;
  for (std::size_t i = 0; i < 12; ++i)
    if (surface.points[surface.facet_corners[i]] != tetrahedron_points[tetrahedron_corners[i]]) return false;
  return true;
}

vtkSmartPointer<vtkPolyData> vtk_tetrahedron() {
  vtkNew<vtkPoints> points;
  for (const auto& point : tetrahedron_points) points->InsertNextPoint(point.data());
  vtkNew<vtkCellArray> faces;
  for (std::size_t f = 0; f < 4; ++f) {
    faces->InsertNextCell(3);
    for (std::size_t k = 0; k < 3; ++k) faces->InsertCellPoint(static_cast<vtkIdType>(tetrahedron_corners[3 * f + k]));
  }
  const auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(points);
  surface->SetPolys(faces);
  return surface;
}

const std::string ply_text =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty double x\nproperty uchar red\n"
    "property double y\nproperty double z\nelement edge 1\nproperty int a\nelement face 4\n"
    "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
    "0 9 0 0\n1 9 0 0\n0 9 1 0\n0.5 9 0.25 1\n17\n3 0 2 1 2 0.5 0.5\n3 0 1 3 0\n3 1 2 3 0\n3 2 0 3 0\n";

TEST(Ply, passes_over_properties_and_elements_that_it_does_not_need) {
  TemporaryFolder folder;
  write_file(folder / "a.ply", ply_text);
  EXPECT_TRUE(is_tetrahedron(read_surface(folder / "a.ply")));
  check_every_beginning(folder / "a.ply", ply_text, [&] { return is_tetrahedron(read_surface(folder / "a.ply")); });
}

TEST(Ply, notes_bytes_after_the_last_element) {
  TemporaryFolder folder;
  write_file(folder / "a.ply", ply_text + "3 0 1 2 0\n");
  EXPECT_THAT(read_surface(folder / "a.ply").notes,
              testing::ElementsAre("a.ply: 10 bytes after the elements were left out"));
}

TEST(Ply, keeps_polygons_and_double_precision) {
  TemporaryFolder folder;
  write_file(
      folder / "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n1 1 0.1\n0 1 0\n4 0 1 2 3\n");
  const NeutralSurface surface = read_surface(folder / "a.ply");
  EXPECT_THAT(surface.facet_corners, testing::ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(surface.points[2][2], 0.1);
}

TEST(Ply, reads_what_vtk_writes) {
  TemporaryFolder folder;
  for (const int order : {VTK_LITTLE_ENDIAN, VTK_BIG_ENDIAN})
    for (const int file_type : {VTK_ASCII, VTK_BINARY}) {
      vtkNew<vtkPLYWriter> writer;
      writer->SetInputData(vtk_tetrahedron());
      writer->SetDataByteOrder(order);
      writer->SetFileType(file_type);
      writer->SetFileName((folder / "a.ply").c_str());
      ASSERT_EQ(writer->Write(), 1);
      EXPECT_TRUE(is_tetrahedron(read_surface(folder / "a.ply")));
      check_every_beginning(folder / "a.ply", read_file(folder / "a.ply"),
                            [&] { return is_tetrahedron(read_surface(folder / "a.ply")); });
    }
}

TEST(Ply, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    std::string text = ply_text;
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.ply", text);
    expect_refusal([&] { read_surface(folder / "a.ply"); }, error_code, words);
  };
  refuses("3 2 0 3 0", "3 2 0 4 0", ErrorCode::invalid, {"face 3", "corner 4", "0 to 3"});
  refuses("3 2 0 3 0", "2 2 0 0", ErrorCode::invalid, {"face 3", "2 corners"});
  refuses("3 2 0 3 0", "3 2 0 -1 0", ErrorCode::invalid, {"a.ply, line", "-1"});
  refuses("element vertex 4", "element vertex 1000000000", ErrorCode::invalid, {"1000000000 elements"});
  refuses("property double z", "property double w", ErrorCode::invalid, {"no property z"});
  refuses("vertex_indices", "corners", ErrorCode::invalid, {"no list vertex_indices"});
  refuses("format ascii", "format utf8", ErrorCode::invalid, {"'utf8'"});
  refuses("element face 4", "element tristrips 4", ErrorCode::unsupported, {"strips"});
  refuses("ply\n", "plx\n", ErrorCode::invalid, {"byte 0"});
}

TEST(Stl, merges_points_that_coincide_exactly) {
  TemporaryFolder folder;
  for (const int file_type : {VTK_ASCII, VTK_BINARY}) {
    vtkNew<vtkSTLWriter> writer;
    writer->SetInputData(vtk_tetrahedron());
    writer->SetFileType(file_type);
    writer->SetFileName((folder / "a.stl").c_str());
    ASSERT_EQ(writer->Write(), 1);
    EXPECT_TRUE(is_tetrahedron_in_any_order(read_surface(folder / "a.stl")));
    EXPECT_LE(check_every_beginning(folder / "a.stl", read_file(folder / "a.stl"),
                                    [&] { return is_tetrahedron_in_any_order(read_surface(folder / "a.stl")); }),
              4);
  }
}

std::string stl_triangle(const std::string& third = "0 1 0") {
  return "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 -0\nvertex " + third + "\nendloop\nendfacet\n";
}

TEST(Stl, takes_several_solids_and_both_zeros_as_one_point) {
  TemporaryFolder folder;
  write_file(folder / "a.stl",
             "solid a b\n" + stl_triangle() + "endsolid a b\nsolid\n" + stl_triangle("-0 1 0") + "endsolid\n");
  const NeutralSurface surface = read_surface(folder / "a.stl");
  EXPECT_EQ(surface.points.size(), 3U);
  EXPECT_THAT(surface.facet_corners, testing::ElementsAre(0, 1, 2, 0, 1, 2));
}

TEST(Stl, tells_binary_from_text_by_length_not_by_its_first_word) {
  TemporaryFolder folder;
  std::string binary = "solid, or so it says" + std::string(60, ' ') + bytes_of_values(std::vector<std::uint32_t>{1});
  binary += bytes_of_values(std::vector<float>{0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2, 0}) + std::string(2, '\0');
  write_file(folder / "a.stl", binary);
  EXPECT_EQ(read_surface(folder / "a.stl").points[1], (std::array{2.0, 0.0, 0.0}));
}

TEST(Stl, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  write_file(folder / "a.stl", std::string(80, 'x') + bytes_of_values(std::vector<std::uint32_t>{1'000'000'000}));
  expect_refusal([&] { read_surface(folder / "a.stl"); }, ErrorCode::invalid,
                 {"a.stl, byte 84", "1000000000 triangles"});
  write_file(folder / "a.stl", std::string(80, 'x') + bytes_of_values(std::vector<std::uint32_t>{0}));
  expect_refusal([&] { read_surface(folder / "a.stl"); }, ErrorCode::invalid, {"a.stl, facets", "none"});
  write_file(folder / "a.stl", "solid a\nfacet normal 0 0 1\nouter circle\n");
  expect_refusal([&] { read_surface(folder / "a.stl"); }, ErrorCode::invalid, {"a.stl, line 3", "'circle'", "loop"});
}

const std::string obj_text =
    "# by hand\nmtllib none.mtl\nv 0 0 0\nv 1 0 0 1.0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nv 0.5 0.25 1\n"
    "f 1 3 2\nf 1/1 2/1 4/1\nf 2//1 3//1 4//1\nf -2/1/1 -4/1/1 -1/1/1\n";

TEST(Obj, reads_every_way_to_name_a_corner) {
  TemporaryFolder folder;
  write_file(folder / "a.obj", obj_text);
  EXPECT_TRUE(is_tetrahedron(read_surface(folder / "a.obj")));
  write_file(folder / "a.obj", obj_text + "l 1 2\np 1\n");
  EXPECT_THAT(read_surface(folder / "a.obj").notes, testing::ElementsAre(testing::HasSubstr("2 points, lines")));
}

TEST(Obj, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  for (const auto& [line, word] : std::vector<std::pair<std::string, std::string>>{{"f 1 2 5\n", "'5'"},
                                                                                   {"f 1 2 0\n", "'0'"},
                                                                                   {"f 1 2 -5\n", "'-5'"},
                                                                                   {"f 1 2\n", "2 corners"},
                                                                                   {"f 1 2 x\n", "'x'"},
                                                                                   {"v 1 2\n", "three coordinates"},
                                                                                   {"f 1 2 \\\n", ""}}) {
    write_file(folder / "a.obj", obj_text + line);
    expect_refusal([&] { read_surface(folder / "a.obj"); },
                   line.find('\\') == std::string::npos ? ErrorCode::invalid : ErrorCode::unsupported,
                   {"a.obj, line 13", word});
  }
  write_file(folder / "a.obj", "v 0 0 0\n");
  expect_refusal([&] { read_surface(folder / "a.obj"); }, ErrorCode::invalid, {"a.obj, facets", "none"});
}

const std::string off_text =
    "OFF # by hand\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0.5 0.25 1\n3 0 2 1 255 0 0\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

TEST(Off, reads_points_and_facets_and_passes_over_colours) {
  TemporaryFolder folder;
  write_file(folder / "a.off", off_text);
  EXPECT_TRUE(is_tetrahedron(read_surface(folder / "a.off")));
  check_every_beginning(folder / "a.off", off_text, [&] { return is_tetrahedron(read_surface(folder / "a.off")); });
  write_file(folder / "a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_EQ(read_surface(folder / "a.off").points.size(), 3U);
}

TEST(Off, notes_lines_after_the_last_facet) {
  TemporaryFolder folder;
  write_file(folder / "a.off", off_text + "# the end\n3 0 1 2\n3 9 9 9\n");
  EXPECT_THAT(read_surface(folder / "a.off").notes,
              testing::ElementsAre("a.off: 2 lines after the facets were left out"));
}

TEST(Off, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& content, const std::vector<std::string>& words) {
    write_file(folder / "a.off", content);
    expect_refusal([&] { read_surface(folder / "a.off"); }, ErrorCode::invalid, words);
  };
  refuses("OFX\n", {"a.off, line 1", "'OFX'"});
  refuses("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", {"a.off, line 6", "corner 3"});
  refuses("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", {"a.off, line 6", "4 corners"});
  refuses("OFF\n3 1 0\n0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", {"a.off, line 3", "'0,5'"});
  refuses("OFF\n1000000000 1 0\n0 0 0\n", {"end of the file"});
  refuses("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", {"facets", "none"});
}

TEST(BrainVisa, is_refused_wherever_it_ends_early) {
  const TemporaryFolder folder;
  const std::string whole =
      "- 4\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n- 4 4 4\n0 2 1\n0 1 3\n1 2 3\n2 0 3\n";
  const auto is_complete = [&] { return read_surface(folder / "a.tri").facet_offsets.size() == 5; };
  EXPECT_EQ(check_every_beginning(folder / "a.tri", whole, is_complete, {.is_text = true}), 1) << "the last line end";
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{{"- 4\n0", "- 999999999\n0"},
                                                                                 {"- 4\n0", "4\n0"},
                                                                                 {"2 0 3", "2 0 4"},
                                                                                 {"1 0 0 0 0 1", "1 0 0"},
                                                                                 {"- 4 4 4", "- -4"},
                                                                                 {"0 1 0 0", "0 x 0 0"}}) {
    std::string damaged = whole;
    damaged.replace(damaged.find(from), from.size(), to);
    write_file(folder / "a.tri", damaged);
    expect_refusal([&] { read_surface(folder / "a.tri"); }, ErrorCode::invalid, {"a.tri"});
  }
}

TEST(Surfaces, are_read_packed_by_gzip) {
  TemporaryFolder folder;
  const std::string off_by_one = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.5 0.25 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  vtkNew<vtkSTLWriter> writer;
  writer->SetInputData(vtk_tetrahedron());
  writer->SetFileTypeToBinary();
  writer->SetFileName((folder / "a.stl").c_str());
  ASSERT_EQ(writer->Write(), 1);
  struct Row {
    const char* name;
    std::string content;
    bool (*is_right)(const NeutralSurface&);
  };
  for (const Row& row : {Row{"a.ply.gz", ply_text, is_tetrahedron}, Row{"a.obj.gz", off_by_one, is_tetrahedron},
                         Row{"A.STL.GZ", read_file(folder / "a.stl"), is_tetrahedron_in_any_order}}) {
    SCOPED_TRACE(row.name);
    const auto path = folder / row.name;
    const gzFile file = ::gzopen(path.c_str(), "wb");
    ::gzwrite(file, row.content.data(), static_cast<unsigned>(row.content.size()));
    ::gzclose(file);
    EXPECT_TRUE(row.is_right(read_surface(path)));
    EXPECT_EQ(check_every_beginning(path, read_file(path), [&] { return row.is_right(read_surface(path)); }), 0);
    write_file(path, row.content);
    expect_refusal([&] { read_surface(path); }, ErrorCode::invalid, {row.name, "byte 0", "gzip"});
  }
  const gzFile file = ::gzopen((folder / "a.ply.gz").c_str(), "wb");
  ::gzclose(file);
  expect_refusal([&] { read_surface(folder / "a.ply.gz"); }, ErrorCode::invalid, {"a.ply.gz", "empty"});
}

}  // namespace
}  // namespace rhoray::preprocess
