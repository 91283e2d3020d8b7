#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkLongLongArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "preprocess/import/readers.h"
#include "preprocess/import/reading/families.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

/// Two tetrahedra and a triangle on five points, by hand.
std::string by_hand(const std::string& corners = "0 1 2 3  0 1 4  1 2 3 4", const std::string& kinds = "10 5 10",
                    const std::string& offsets = "4 7 11",
                    const std::string& counts = "NumberOfPoints=\"5\" NumberOfCells=\"3\"") {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
         "<UnstructuredGrid><Piece " +
         counts +
         ">\n"
         "<PointData><DataArray type=\"Float64\" Name=\"voltage\" format=\"ascii\">1 2 3 4 5.1</DataArray>\n"
         "<DataArray type=\"Float32\" Name=\"flow\" NumberOfComponents=\"3\" format=\"ascii\">1 0 0 2 0 0 3 0 0 4 0 0 "
         "5 0 6</DataArray>"
         "</PointData>\n<CellData><DataArray type=\"Int32\" Name=\"tissue\" format=\"ascii\">7 8 "
         "9</DataArray></CellData>\n"
         "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1 1 1 "
         "0.1</DataArray></Points>\n"
         "<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" +
         corners +
         "</DataArray>\n"
         "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">" +
         offsets +
         "</DataArray>\n"
         "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">" +
         kinds +
         "</DataArray></Cells>\n"
         "</Piece></UnstructuredGrid></VTKFile>\n";
}

bool is_complete(const NeutralMesh& mesh) {
  return mesh.points.size() == 5 && mesh.points[4][2] == 0.1 && mesh.cells.size() == 2 &&
         mesh.cells[1] == std::array<std::uint64_t, 4>{1, 2, 3, 4} && mesh.point_fields.size() == 2 &&
         mesh.point_fields[0].values == Array<double>{1, 2, 3, 4, 5.1} && mesh.point_fields[1].values[14] == 6 &&
         mesh.cell_fields.size() == 1 && mesh.cell_fields[0].values == Array<double>{7, 9};
}

TEST(Vtu, keeps_tetrahedra_with_their_fields) {
  TemporaryFolder folder;
  write_file(folder / "a.vtu", by_hand());
  const NeutralMesh mesh = read_mesh(folder / "a.vtu");
  EXPECT_TRUE(is_complete(mesh));
  EXPECT_THAT(mesh.cell_ids, testing::ElementsAre(0, 2));
  EXPECT_THAT(mesh.notes, testing::ElementsAre("1 triangle left out: only cells that fill space are kept"));
  EXPECT_EQ(mesh.point_fields[0].name, "voltage");
  EXPECT_FALSE(mesh.point_fields[0].was_single_precision);
  EXPECT_EQ(mesh.point_fields[1].component_count, 3);
  EXPECT_TRUE(mesh.point_fields[1].was_single_precision);
  EXPECT_TRUE(mesh.cell_fields[0].was_single_precision);
}

TEST(Vtu, refuses_every_beginning_of_a_text_file) {
  TemporaryFolder folder;
  EXPECT_LE(check_every_beginning(folder / "a.vtu", by_hand(), [&] { return is_complete(read_mesh(folder / "a.vtu")); },
                                  {.stride = 3}),
            1);
}

TEST(Vtu, refuses_every_beginning_of_what_it_writes) {
  TemporaryFolder folder;
  write_file(folder / "a.vtu", by_hand());
  NeutralMesh mesh = read_mesh(folder / "a.vtu");
  write_vtu(mesh, folder / "b.vtu");
  const std::string content = read_file(folder / "b.vtu");
  EXPECT_THAT(content, testing::HasSubstr("encoding=\"raw\""));
  EXPECT_THAT(content, testing::HasSubstr("vtkZLibDataCompressor"));
  EXPECT_TRUE(is_complete(read_mesh(folder / "b.vtu")));
  EXPECT_LE(check_every_beginning(folder / "b.vtu", content, [&] { return is_complete(read_mesh(folder / "b.vtu")); },
                                  {.stride = 3}),
            static_cast<int>(std::string_view("\n  </AppendedData>\n</VTKFile>\n").size()));
}

TEST(Vtu, writes_what_it_reads_again_bit_for_bit) {
  TemporaryFolder folder;
  NeutralMesh mesh;
  for (int i = 0; i < 20; ++i) mesh.points.push_back({i / 3.0, i * 1e7 + 0.1, -i / 7.0});
  for (std::uint64_t i = 0; i + 3 < 20; ++i) mesh.cells.push_back({i + 3, i, i + 1, i + 2});
  mesh.point_fields = {{"a", "", 1, false, {}}, {"b", "", 2, true, {}}};
  for (int i = 0; i < 20; ++i) mesh.point_fields[0].values.push_back(i / 9.0);
  for (int i = 0; i < 40; ++i) mesh.point_fields[1].values.push_back(i / 4.0);
  mesh.point_fields[0].values[3] = NAN;
  mesh.cell_fields = {{"c d", "", 1, true, Array<double>(17, INFINITY)}};
  write_vtu(mesh, folder / "a.vtu");
  const NeutralMesh read = read_mesh(folder / "a.vtu");
  EXPECT_EQ(read.points, mesh.points);
  EXPECT_EQ(read.cells, mesh.cells);
  EXPECT_TRUE(std::isnan(read.point_fields[0].values[3]));
  EXPECT_EQ(read.point_fields[0].values[19], 19 / 9.0);
  EXPECT_FALSE(read.point_fields[0].was_single_precision);
  EXPECT_EQ(read.point_fields[1].values, mesh.point_fields[1].values);
  EXPECT_EQ(read.cell_fields[0].name, "c d");
  EXPECT_EQ(read.cell_fields[0].values, mesh.cell_fields[0].values);
}

TEST(Vtu, refuses_to_write_what_does_not_fit_or_where_it_cannot) {
  TemporaryFolder folder;
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.cells = {{0, 1, 2, 4}};
  expect_refusal([&] { write_vtu(mesh, folder / "a.vtu"); }, ErrorCode::invalid, {"cell 0", "point 4"});
  mesh.cells = {{0, 1, 2, 3}};
  expect_refusal([&] { write_vtu(mesh, folder / "no/such/folder.vtu"); }, ErrorCode::usage, {"folder.vtu"});
}

TEST(Vtu, notes_arrays_that_are_no_numbers_and_integers_that_were_rounded) {
  TemporaryFolder folder;
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkPoints> points;
  for (int i = 0; i < 4; ++i) points->InsertNextPoint(i == 1, i == 2, i == 3);
  grid->SetPoints(points);
  const vtkIdType corners[4] = {0, 1, 2, 3};
  grid->InsertNextCell(VTK_TETRA, 4, corners);
  vtkNew<vtkStringArray> names;
  names->SetName("names");
  for (int i = 0; i < 4; ++i) names->InsertNextValue("x");
  grid->GetPointData()->AddArray(names);
  vtkNew<vtkLongLongArray> wide;
  wide->SetName("wide");
  for (int i = 0; i < 4; ++i) wide->InsertNextValue((1LL << 60) + 1);
  grid->GetPointData()->AddArray(wide);
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(grid);
  writer->SetFileName((folder / "a.vtu").c_str());
  ASSERT_EQ(writer->Write(), 1);
  const NeutralMesh mesh = read_mesh(folder / "a.vtu");
  EXPECT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_THAT(mesh.notes,
              testing::UnorderedElementsAre(testing::HasSubstr("'names' left out"), testing::HasSubstr("beyond 2^53")));
}

TEST(Vtu, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtu";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read_mesh(path); }, error_code, words);
  };
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 5"), ErrorCode::invalid, {"cell 2", "point 5", "0 to 4"});
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 -7"), ErrorCode::invalid, {"cell 2", "point -7"});
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 4", "10 5 14"), ErrorCode::invalid, {"cell 2", "5, as pyramids have"});
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 4", "10 10 10"), ErrorCode::invalid, {"cell 1", "3 corners"});
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 4", "10 5 10", "4 3 11"), ErrorCode::invalid, {"a.vtu"});
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 4", "10 5 10", "4 7 999999"), ErrorCode::invalid, {"a.vtu"});
  refuses(by_hand("0 1 2 3"), ErrorCode::invalid, {"a.vtu"});
  refuses(by_hand("0 1 2 3  0 1 4  1 2 3 4", "10 5"), ErrorCode::invalid, {"a.vtu"});
  const auto counts = [](const std::string& text) {
    return by_hand("0 1 2 3  0 1 4  1 2 3 4", "10 5 10", "4 7 11", text);
  };
  refuses(counts("NumberOfPoints=\"6\" NumberOfCells=\"3\""), ErrorCode::invalid, {"a.vtu"});
  refuses(counts("NumberOfPoints=\"5\" NumberOfCells=\"4\""), ErrorCode::invalid, {"a.vtu"});
  refuses(counts("NumberOfPoints=\"1000000000\" NumberOfCells=\"3\""), ErrorCode::invalid,
          {"NumberOfPoints", "1000000000 in"});
  refuses(counts("NumberOfPoints=\"-5\" NumberOfCells=\"3\""), ErrorCode::invalid, {"NumberOfPoints", "'-5'"});
  refuses(counts("NumberOfPoints=\"0\" NumberOfCells=\"0\""), ErrorCode::invalid, {"a.vtu"});
  refuses("<VTKFile type=\"PolyData\" version=\"0.1\"></VTKFile>", ErrorCode::unsupported,
          {"'PolyData'", "UnstructuredGrid"});
  refuses("# vtk DataFile", ErrorCode::invalid, {"no element VTKFile"});
  expect_refusal([&] { read_mesh(folder / "none.vtu"); }, ErrorCode::unreadable, {"none.vtu"});
}

}  // namespace
}  // namespace rhoray::preprocess
