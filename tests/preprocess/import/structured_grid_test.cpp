// Structured grids, VTS and legacy VTK, as hexahedra; written by VTK itself.

#include <vtkNew.h>
#include <vtkStructuredGrid.h>
#include <vtkStructuredGridWriter.h>
#include <vtkXMLStructuredGridWriter.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/legacy_writer.h"
#include "tests/preprocess/import/vtk_cells.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::ElementsAre;
using testing::HasSubstr;

/// The lattice of support.h, bent: points (i, j, k) at (i, j + i/4, 2 k), v = value_at(i, j, k), c
/// = number of the cell.
vtkSmartPointer<vtkStructuredGrid> bent_lattice() {
  const auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> v;
  v->SetName("v");
  for (int k = 0; k < size_z; ++k)
    for (int j = 0; j < size_y; ++j)
      for (int i = 0; i < size_x; ++i) {
        points->InsertNextPoint(i, j + 0.25 * i, 2 * k);
        v->InsertNextValue(value_at(i, j, k));
      }
  grid->SetDimensions(size_x, size_y, size_z);
  grid->SetPoints(points);
  grid->GetPointData()->AddArray(v);
  vtkNew<vtkIntArray> c;
  c->SetName("c");
  for (int cell = 0; cell < grid->GetNumberOfCells(); ++cell) c->InsertNextValue(cell);
  grid->GetCellData()->AddArray(c);
  return grid;
}

/// Cells of the mesh are those of VTK's own view of the grid that are visible.
void expect_cells_of(const CellMesh& mesh, vtkStructuredGrid& grid) {
  ASSERT_EQ(mesh.points.size(), value_count);
  vtkNew<vtkIdList> nodes;
  std::size_t at = 0;
  for (vtkIdType cell = 0; cell < grid.GetNumberOfCells(); ++cell) {
    if (grid.IsCellVisible(cell) == 0) continue;
    ASSERT_LT(at, mesh.kinds.size());
    EXPECT_EQ(mesh.kinds[at], CellKind::hexahedron);
    grid.GetCellPoints(cell, nodes);
    EXPECT_EQ(nodes_of(mesh, at), std::vector<std::uint64_t>(nodes->begin(), nodes->end()));
    EXPECT_EQ(mesh.cell_fields[0].values[at], static_cast<double>(cell));
    EXPECT_EQ(mesh.cell_ids.empty() ? at : mesh.cell_ids[at], static_cast<std::uint64_t>(cell));
    ++at;
  }
  EXPECT_EQ(mesh.kinds.size(), at);
  for (std::size_t i = 0; i < value_count; ++i) {
    double expected[3];
    grid.GetPoint(static_cast<vtkIdType>(i), expected);
    EXPECT_EQ(mesh.points[i], (std::array{expected[0], expected[1], expected[2]}));
  }
  EXPECT_EQ(std::vector<double>(mesh.point_fields[0].values.begin(), mesh.point_fields[0].values.end()),
            known_values<double>());
  EXPECT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(mesh.cell_fields.size(), 1U);
}

void write_vts(vtkStructuredGrid* grid, const std::filesystem::path& path, int mode = vtkXMLWriter::Appended) {
  vtkNew<vtkXMLStructuredGridWriter> writer;
  writer->SetInputData(grid);
  writer->SetDataMode(mode);
  writer->SetFileName(path.c_str());
  ASSERT_EQ(writer->Write(), 1);
}

TEST(StructuredGrid, becomes_the_hexahedra_that_vtk_sees) {
  TemporaryFolder folder;
  const auto grid = bent_lattice();
  for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended}) {
    write_vts(grid, folder / "a.vts", mode);
    const CellMesh mesh = read_cells(folder / "a.vts", {});
    expect_cells_of(mesh, *grid);
    EXPECT_EQ(mesh.kinds.size(), 24U);
    EXPECT_TRUE(mesh.cell_ids.empty());
  }
  for (const int version : {42, 51})
    for (const int file_type : {VTK_ASCII, VTK_BINARY}) {
      write_legacy_vtk<vtkStructuredGridWriter>(grid, folder / "a.vtk", file_type, version);
      expect_cells_of(read_cells(folder / "a.vtk", {}), *grid);
    }
}

TEST(StructuredGrid, goes_without_cells_that_are_hidden_or_touch_a_hidden_point) {
  TemporaryFolder folder;
  const auto grid = bent_lattice();
  grid->BlankCell(5);
  grid->BlankCell(23);
  grid->BlankPoint(0);  // cell 0 alone has it
  write_vts(grid, folder / "a.vts");
  write_legacy_vtk<vtkStructuredGridWriter>(grid, folder / "a.vtk", VTK_BINARY, 51);
  for (const char* name : {"a.vts", "a.vtk"}) {
    SCOPED_TRACE(name);
    const CellMesh mesh = read_cells(folder / name, {});
    expect_cells_of(mesh, *grid);
    EXPECT_EQ(mesh.kinds.size(), 21U);
    EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("2 hidden cells"), HasSubstr("1 cell with a hidden point left out")));
  }
}

TEST(StructuredGrid, keeps_to_the_blanking_of_very_old_files) {
  TemporaryFolder folder;
  const std::string points =
      "POINTS 12 float\n0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 1 1 1 2 1 1\n";
  const std::string head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 3 2 2\n";
  write_file(folder / "a.vtk", head + "BLANKING 12 unsigned_char\n1 1 1 1 1 0 1 1 1 1 1 1\n" + points);
  const CellMesh mesh = read_cells(folder / "a.vtk", {});
  EXPECT_THAT(mesh.cell_ids, ElementsAre(0));
  EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 4, 3, 6, 7, 10, 9));
  write_file(folder / "a.vtk", head + "BLANKING 11 unsigned_char\n1 1 1 1 1 0 1 1 1 1 1\n" + points);
  expect_refusal([&] { read_cells(folder / "a.vtk", {}); }, ErrorCode::invalid, {"11 numbers", "12"});
}

TEST(StructuredGrid, is_refused_with_one_layer_or_other_sizes) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& sizes, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(folder / "a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS " + sizes +
                                     "\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 1 1 0\n");
    expect_refusal([&] { read_cells(folder / "a.vtk", {}); }, error_code, words);
  };
  refuses("2 2 1", ErrorCode::unsupported, {"2 x 2 x 1 points", "one layer"});
  refuses("-2 2 2", ErrorCode::unsupported, {"-2 x 2 x 2"});
  refuses("2 2 2", ErrorCode::invalid, {"4 points", "2 x 2 x 2"});
  refuses("4294967296 4294967296 4", ErrorCode::invalid, {"4 points"});
  vtkNew<vtkStructuredGrid> layer;
  vtkNew<vtkPoints> points;
  for (int i = 0; i < 4; ++i) points->InsertNextPoint(i % 2, i / 2, 0);
  layer->SetDimensions(2, 2, 1);
  layer->SetPoints(points);
  write_vts(layer, folder / "a.vts");
  expect_refusal([&] { read_cells(folder / "a.vts", {}); }, ErrorCode::unsupported, {"a.vts", "2 x 2 x 1 points"});
}

TEST(StructuredGrid, is_refused_where_its_pieces_or_arrays_are_not_all_there) {
  TemporaryFolder folder;
  write_vts(bent_lattice(), folder / "a.vts", vtkXMLWriter::Ascii);
  const std::string text = read_file(folder / "a.vts");
  const auto refuses = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    ASSERT_NE(other.find(from), std::string::npos);
    other.replace(other.find(from), from.size(), to);
    write_file(folder / "b.vts", other);
    expect_refusal([&] { read_cells(folder / "b.vts", {}); }, ErrorCode::invalid, {"b.vts"});
  };
  refuses("<Piece Extent=\"0 2 0 3 0 4\"", "<Piece Extent=\"0 2 0 3 0 3\"");
  refuses("WholeExtent=\"0 2 0 3 0 4\"", "WholeExtent=\"0 2 0 3 0 5\"");
  refuses("WholeExtent=\"0 2 0 3 0 4\"", "WholeExtent=\"0 2000000000 0 2000000000 0 4\"");
  refuses("WholeExtent=\"0 2 0 3 0 4\"", "WholeExtent=\"0 2 0 3 0\"");
  refuses("<Piece Extent=\"0 2 0 3 0 4\"", "<Piece Extent=\"0 2 0 3 1 5\"");
}

/// Two pieces that share a layer of points make up the whole; the same piece twice does not.
TEST(StructuredGrid, is_put_together_from_pieces_that_cover_it) {
  TemporaryFolder folder;
  const auto write = [&](const std::string& first, const std::string& second) {
    const auto piece = [](const std::string& extent, int x) {
      std::string points;
      for (const int k : {0, 1})
        for (const int j : {0, 1})
          for (const int i : {0, 1}) points += concat(x + i, " ", j, " ", k, " ");
      return "<Piece Extent=\"" + extent + "\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" " +
             "format=\"ascii\">" + points + "</DataArray></Points></Piece>\n";
    };
    write_file(folder / "a.vts",
               "<VTKFile type=\"StructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<StructuredGrid "
               "WholeExtent=\"0 2 0 1 0 1\">\n" +
                   piece(first, 0) + piece(second, 1) + "</StructuredGrid></VTKFile>\n");
  };
  write("0 1 0 1 0 1", "1 2 0 1 0 1");
  const CellMesh mesh = read_cells(folder / "a.vts", {});
  ASSERT_EQ(mesh.points.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(mesh.points[i][0], static_cast<double>(i % 3));
  EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 4, 3, 6, 7, 10, 9, 1, 2, 5, 4, 7, 8, 11, 10));
  write("0 1 0 1 0 1", "0 1 0 1 0 1");
  expect_refusal([&] { read_cells(folder / "a.vts", {}); }, ErrorCode::invalid, {"2 pieces that do not make up"});
}

TEST(StructuredGrid, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const auto grid = bent_lattice();
  const auto is_complete = [](const std::filesystem::path& path) {
    const CellMesh mesh = read_cells(path, {});
    return mesh.kinds.size() == 24 && mesh.points.back()[2] == 8 && mesh.point_fields.size() == 1 &&
           mesh.point_fields[0].values.back() == 152 &&
           (mesh.cell_fields.empty() || mesh.cell_fields[0].values.back() == 23);
  };
  write_vts(grid, folder / "a.vts");
  const std::string appended = read_file(folder / "a.vts");
  EXPECT_TRUE(is_complete(folder / "a.vts"));
  check_every_beginning(folder / "a.vts", appended, [&] { return is_complete(folder / "a.vts"); }, {.stride = 17});
  write_legacy_vtk<vtkStructuredGridWriter>(grid, folder / "a.vtk", VTK_BINARY, 42);
  const std::string legacy = read_file(folder / "a.vtk");
  EXPECT_TRUE(is_complete(folder / "a.vtk"));
  check_every_beginning(
      folder / "a.vtk", legacy,
      [&] {
        const CellMesh mesh = read_cells(folder / "a.vtk", {});  // cells and fields may come later: a smaller file
        return mesh.kinds.size() == 24 && (mesh.cell_fields.empty() || mesh.cell_fields[0].values.back() == 23);
      },
      {.stride = 3});
}

}  // namespace
}  // namespace rhoray::preprocess
