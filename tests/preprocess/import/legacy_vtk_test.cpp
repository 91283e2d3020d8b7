#include <vtkCellData.h>
#include <vtkDataSetWriter.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataWriter.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>

#include <numeric>

#include "preprocess/import/readers.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/legacy_writer.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/vtk_lattice.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

const std::string volume_text =
    "# vtk DataFile Version 3.0\na title\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 4 5\n"
    "SPACING 2 3 4\nORIGIN 10 20 30\nPOINT_DATA 60\nSCALARS v short 1\nLOOKUP_TABLE default\n" +
    values_in_text();

const std::string mesh_text =
    "# vtk DataFile Version 2.0\ntwo tetrahedra, a line between them\nASCII\nDATASET UNSTRUCTURED_GRID\n"
    "POINTS 5 double\n0 0 0  1 0 0  0 1 0  0 0 1  1 1 1.5\n"
    "CELLS 3 13\n4 0 1 2 3\n2 0 4\n4 1 2 3 4\nCELL_TYPES 3\n10 3 10\n"
    "POINT_DATA 5\nSCALARS voltage float\nLOOKUP_TABLE default\n1 2 3 4 nan\nVECTORS flow double\n"
    "1 0 0 2 0 0 3 0 0 4 0 0 5 0 0.1\n"
    "CELL_DATA 3\nFIELD FieldData 1\ntissue%20number 1 3 int\n7 8 9\n";

NeutralVolume read(const std::filesystem::path& path) {
  return read_volume(path, {});
}

TEST(LegacyVtkVolume, keeps_spacing_origin_and_type) {
  TemporaryFolder folder;
  write_file(folder / "a.vtk", volume_text);
  const NeutralVolume volume = read(folder / "a.vtk");
  expect_known_values(volume, ElementType::I16);
  expect_map(volume.world_from_grid, axis_parallel_map({2, 3, 4}, {10, 20, 30}));
  EXPECT_EQ(volume.field_name, "v");
}

TEST(LegacyVtkVolume, keeps_the_unit_and_takes_hidden_points_as_no_data) {
  TemporaryFolder folder;
  std::string hidden;
  for (std::size_t i = 0; i < value_count; ++i) hidden += i == 3 ? "2 " : "0 ";
  write_file(folder / "a.vtk", volume_text.substr(0, volume_text.find("SCALARS")) +
                                   "FIELD FieldData 2\nvtkGhostType 1 60 unsigned_char\n" + hidden +
                                   "\nv 1 60 float\n" + values_in_text() +
                                   "METADATA\nINFORMATION 1\nNAME UNITS_LABEL LOCATION vtkDataArray\nDATA mmHg\n\n");
  const NeutralVolume volume = read(folder / "a.vtk");
  EXPECT_EQ(volume.field_name, "v");
  EXPECT_EQ(volume.field_unit, "mmHg");
  EXPECT_TRUE(volume.other_fields.empty());
  EXPECT_TRUE(std::isnan(values_of(volume)[3]));
  EXPECT_EQ(values_of(volume)[4], known_values<double>()[4]);
}

/// VTK writes files of version 5.1 and 4.2, in text and in binary; METADATA blocks come with them.
TEST(LegacyVtkVolume, reads_what_vtk_writes) {
  TemporaryFolder folder;
  for (const int file_type : {VTK_ASCII, VTK_BINARY})
    for (const auto& [vtk_type, type] :
         {std::pair(VTK_UNSIGNED_CHAR, ElementType::U8), std::pair(VTK_SHORT, ElementType::I16),
          std::pair(VTK_FLOAT, ElementType::F32), std::pair(VTK_DOUBLE, ElementType::F64)}) {
      const vtkSmartPointer<vtkImageData> image = vtk_lattice(vtk_type);
      image->SetSpacing(2, 3, 4);
      image->SetOrigin(10, 20, 30);
      vtkNew<vtkFloatArray> extra;  // an array before and one behind the scalars
      extra->SetName("two words");
      extra->SetNumberOfComponents(2);
      extra->SetComponentName(0, "first");
      for (std::size_t i = 0; i < value_count; ++i) extra->InsertNextTuple2(static_cast<double>(i), -1);
      image->GetPointData()->AddArray(extra);
      vtkNew<vtkDataSetWriter> writer;
      writer->SetInputData(image);
      writer->SetFileType(file_type);
      writer->SetFileName((folder / "a.vtk").c_str());
      ASSERT_EQ(writer->Write(), 1);
      const NeutralVolume volume = read(folder / "a.vtk");
      expect_known_values(volume, type);
      expect_map(volume.world_from_grid, axis_parallel_map({2, 3, 4}, {10, 20, 30}));
      EXPECT_EQ(values_of(read_volume(folder / "a.vtk", {.raw = {}, .field = "two words.x"}))[59], 59);
    }
}

TEST(LegacyVtkVolume, refuses_counts_that_do_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, const std::vector<std::string>& words) {
    std::string text = volume_text;
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.vtk", text);
    expect_refusal([&] { read(folder / "a.vtk"); }, ErrorCode::invalid, words);
  };
  refuses("POINT_DATA 60", "POINT_DATA 61", {"a.vtk", "end of the file"});
  refuses("POINT_DATA 60", "POINT_DATA 59", {"a.vtk, line", "keyword"});
  refuses("POINT_DATA 60", "POINT_DATA 1000000000", {"1000000000 x 1 numbers"});
  refuses("POINT_DATA 60", "POINT_DATA 18446744073709551615", {"18446744073709551615"});
  refuses("DIMENSIONS 3 4 5", "DIMENSIONS 3 4 6", {"array 'v'"});
  refuses("DIMENSIONS 3 4 5", "DIMENSIONS 3 4", {"line 6", "'SPACING'"});
  refuses("SPACING 2 3 4", "SPACING 2 0 4", {"spacing of 0"});
}

TEST(LegacyVtkVolume, refuses_texts_and_reads_bytes_given_as_fractions) {
  TemporaryFolder folder;
  std::string text = volume_text;
  text.replace(text.find("short"), 5, "string");
  write_file(folder / "a.vtk", text);
  expect_refusal([&] { read(folder / "a.vtk"); }, ErrorCode::unsupported, {"a.vtk, line 9", "'string'"});
  const std::string start = volume_text.substr(0, volume_text.find("DIMENSIONS"));
  write_file(folder / "a.vtk", concat(start, "DIMENSIONS 2 1 1\nPOINT_DATA 2\nCOLOR_SCALARS c 2\n0 1 0.5 0.2\n"));
  EXPECT_THAT(values_of(read_volume(folder / "a.vtk", {.raw = {}, .field = "c.x"})), testing::ElementsAre(0, 128));
  write_file(folder / "a.vtk", concat(start, "DIMENSIONS 2 1 1\nPOINT_DATA 2\nCOLOR_SCALARS c 2\n0 1 0.5 1.2\n"));
  expect_refusal([&] { read(folder / "a.vtk"); }, ErrorCode::invalid, {"1.2", "0 to 1"});
}

TEST(LegacyVtkVolume, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const auto is_complete = [&] { return values_of(read(folder / "a.vtk")) == known_values<double>(); };
  check_every_beginning(folder / "a.vtk", volume_text, is_complete, {.stride = 3, .is_text = true});
  std::string binary =
      volume_text.substr(0, volume_text.find("default\n") + 8) + bytes_of_values(known_values<std::int16_t>(), true);
  binary.replace(binary.find("ASCII"), 5, "BINARY");
  EXPECT_EQ(check_every_beginning(folder / "a.vtk", binary, is_complete), 0);
  EXPECT_TRUE(is_complete());
}

TEST(LegacyVtkMesh, keeps_tetrahedra_with_their_fields) {
  TemporaryFolder folder;
  write_file(folder / "a.vtk", mesh_text);
  const NeutralMesh mesh = read_mesh(folder / "a.vtk");
  EXPECT_THAT(mesh.cells,
              testing::ElementsAre(std::array<std::uint64_t, 4>{0, 1, 2, 3}, std::array<std::uint64_t, 4>{1, 2, 3, 4}));
  EXPECT_EQ(mesh.points[4], (std::array{1.0, 1.0, 1.5}));
  EXPECT_THAT(mesh.cell_ids, testing::ElementsAre(0, 2));
  EXPECT_THAT(mesh.notes, testing::ElementsAre(testing::HasSubstr("1 line left out")));
  ASSERT_EQ(mesh.point_fields.size(), 2U);
  EXPECT_EQ(mesh.point_fields[0].name, "voltage");
  EXPECT_TRUE(std::isnan(mesh.point_fields[0].values[4]));
  EXPECT_TRUE(mesh.point_fields[0].was_single_precision);
  EXPECT_EQ(mesh.point_fields[1].component_count, 3);
  EXPECT_EQ(mesh.point_fields[1].values[14], 0.1);
  EXPECT_FALSE(mesh.point_fields[1].was_single_precision);
  ASSERT_EQ(mesh.cell_fields.size(), 1U);
  EXPECT_EQ(mesh.cell_fields[0].name, "tissue number");
  EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(7, 9));
}

TEST(LegacyVtkMesh, reads_what_vtk_writes) {
  TemporaryFolder folder;
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkPoints> points;
  for (int i = 0; i < 5; ++i) points->InsertNextPoint(i == 1, i == 2, i >= 3 ? i : 0);
  grid->SetPoints(points);
  const vtkIdType cells[2][4] = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  for (const auto& cell : cells) grid->InsertNextCell(VTK_TETRA, 4, cell);
  vtkNew<vtkIntArray> tissue;
  tissue->SetName("tissue");
  tissue->InsertNextValue(16777217);  // needs more than a 32-bit float
  tissue->InsertNextValue(-3);
  grid->GetCellData()->AddArray(tissue);
  for (const int version : {42, 51})
    for (const int file_type : {VTK_ASCII, VTK_BINARY}) {
      write_legacy_vtk<vtkUnstructuredGridWriter>(grid, folder / "a.vtk", file_type, version);
      const NeutralMesh mesh = read_mesh(folder / "a.vtk");
      ASSERT_EQ(mesh.cells.size(), 2U);
      EXPECT_EQ(mesh.cells[1], (std::array<std::uint64_t, 4>{0, 2, 1, 4}));
      EXPECT_EQ(mesh.points[4], (std::array{0.0, 0.0, 4.0}));
      EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(16777217, -3));
      EXPECT_FALSE(mesh.cell_fields[0].was_single_precision);
      EXPECT_TRUE(mesh.cell_ids.empty());
      const std::string content = read_file(folder / "a.vtk");
      check_every_beginning(
          folder / "a.vtk", content,
          [&] {
            const NeutralMesh part =
                read_mesh(folder / "a.vtk");  // may end before CELL_DATA, which is a smaller file, not a broken one
            return part.cells == mesh.cells &&
                   (part.cell_fields.empty() || part.cell_fields[0].values == mesh.cell_fields[0].values);
          },
          {.stride = 3, .is_text = file_type == VTK_ASCII});
    }
}

TEST(LegacyVtkMesh, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    std::string text = mesh_text;
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.vtk", text);
    expect_refusal([&] { read_mesh(folder / "a.vtk"); }, error_code, words);
  };
  refuses("4 1 2 3 4", "4 1 2 3 5", ErrorCode::invalid, {"cell 2", "point 5", "0 to 4"});
  refuses("4 1 2 3 4", "4 1 2 3 -1", ErrorCode::invalid, {"cell 2", "point -1"});
  refuses("4 1 2 3 4", "3 1 2 3 4", ErrorCode::invalid, {"CELLS", "12 numbers", "13"});
  refuses("4 1 2 3 4", "9 1 2 3 4", ErrorCode::invalid, {"cell 2", "more corners"});
  refuses("10 3 10", "10 3 12", ErrorCode::invalid, {"cell 2", "4 corners", "8, as hexahedra have"});
  refuses("10 3 10", "24 24 99", ErrorCode::unsupported, {"1 cell of VTK's kind 99"});
  refuses("10 3 10", "3 3 3", ErrorCode::invalid, {"3 lines", "at least one that fills space"});
  refuses("2 0 4", "1 0", ErrorCode::invalid, {"a.vtk"});
  refuses("CELL_TYPES 3\n10 3 10", "CELL_TYPES 2\n10 3", ErrorCode::invalid, {"2 kinds for 3 cells"});
  refuses("POINTS 5", "POINTS 1000000000", ErrorCode::invalid, {"1000000000 x 3"});
  refuses("tissue%20number 1 3", "tissue%20number 1 2", ErrorCode::invalid, {"tissue number", "2 tuples"});
  refuses("POINT_DATA 5", "POINT_DATA 4", ErrorCode::invalid, {"a.vtk"});
  refuses("UNSTRUCTURED_GRID", "POLYDATA", ErrorCode::unsupported, {"found POLYDATA", "UNSTRUCTURED_GRID"});
  refuses("UNSTRUCTURED_GRID", "TABLE", ErrorCode::unsupported, {"'TABLE'", "POLYDATA"});
  refuses("ASCII", "ASCII?", ErrorCode::invalid, {"ASCII or BINARY"});
  refuses("# vtk", "# VTK", ErrorCode::invalid, {"line 1"});
}

TEST(LegacyVtkSurface, takes_polygons_and_strips_that_vtk_writes) {
  TemporaryFolder folder;
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  for (int i = 0; i < 6; ++i) points->InsertNextPoint(i % 2, i / 2, i == 5 ? 1 : 0);
  data->SetPoints(points);
  const auto cells = [](const std::vector<std::vector<vtkIdType>>& all) {
    const auto array = vtkSmartPointer<vtkCellArray>::New();
    for (const auto& nodes : all) array->InsertNextCell(static_cast<vtkIdType>(nodes.size()), nodes.data());
    return array;
  };
  data->SetVerts(cells({{0}, {1}}));
  data->SetLines(cells({{0, 5}}));
  data->SetPolys(cells({{0, 1, 2}, {0, 1, 3, 2}}));
  data->SetStrips(cells({{0, 1, 2, 3, 4}}));
  vtkNew<vtkFloatArray> v;
  v->SetName("v");
  v->SetNumberOfTuples(6);
  v->FillComponent(0, 1);
  data->GetPointData()->AddArray(v);
  for (const int version : {42, 51})
    for (const int file_type : {VTK_ASCII, VTK_BINARY}) {
      write_legacy_vtk<vtkPolyDataWriter>(data, folder / "a.vtk", file_type, version);
      const NeutralSurface surface = read_surface(folder / "a.vtk");
      EXPECT_THAT(surface.facet_offsets, testing::ElementsAre(0, 3, 7, 10, 13, 16));
      EXPECT_THAT(surface.facet_corners, testing::ElementsAre(0, 1, 2, 0, 1, 3, 2, 0, 1, 2, 1, 3, 2, 2, 3, 4));
      EXPECT_EQ(surface.points[5], (std::array{1.0, 2.0, 1.0}));
      EXPECT_THAT(surface.notes, testing::ElementsAre("3 vertices and lines left out", testing::HasSubstr("1 field")));
    }
  const std::string head =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
  const auto refuses = [&](const std::string& rest, const std::vector<std::string>& words) {
    write_file(folder / "a.vtk", head + rest);
    expect_refusal([&] { read_surface(folder / "a.vtk"); }, ErrorCode::invalid, words);
  };
  refuses("POLYGONS 1 4\n3 0 1 3\n", {"polygon 0", "corner 3"});
  refuses("POLYGONS 1 3\n2 0 1\n", {"polygon 0", "2 corners"});
  refuses("POLYGONS 3 3\nOFFSETS vtktypeint64\n0 3 2\nCONNECTIVITY vtktypeint64\n0 1 2\n", {"polygon 1", "offset"});
  refuses("LINES 1 3\n2 0 1\n", {"facets", "none"});
}

TEST(LegacyVtkMesh, turns_old_lagrange_hexahedra_and_refuses_uneven_ones) {
  TemporaryFolder folder;
  const auto file = [](const std::string& version, int count) {
    std::string text = "# vtk DataFile Version " + version + "\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 27 float\n";
    for (int i = 0; i < 81; ++i) text += "0 ";
    text += concat("\nCELLS 1 ", count + 1, "\n", count);
    for (int i = 0; i < count; ++i) text += concat(" ", i);
    return text + "\nCELL_TYPES 1\n72\n";
  };
  Array<std::uint64_t> expected(27);
  std::iota(expected.begin(), expected.end(), std::uint64_t{0});
  write_file(folder / "a.vtk", file("5.1", 27));
  EXPECT_EQ(read_cells(folder / "a.vtk", {}).cell_nodes, expected);
  std::swap(expected[18], expected[19]);
  for (const char* version : {"5.0", "4.2", "2.0"}) {
    write_file(folder / "a.vtk", file(version, 27));
    EXPECT_EQ(read_cells(folder / "a.vtk", {}).cell_nodes, expected);
  }
  write_file(folder / "a.vtk", file("4.2", 18));
  expect_refusal([&] { read_cells(folder / "a.vtk", {}); }, ErrorCode::unsupported, {"cell 0", "18 corners"});
}

TEST(ForeignKind, asks_legacy_vtk_files_themselves) {
  TemporaryFolder folder;
  write_file(folder / "a.vtk", volume_text);
  EXPECT_EQ(foreign_kind(folder / "a.vtk"), ForeignKind::volume);
  write_file(folder / "a.vtk", mesh_text);
  EXPECT_EQ(foreign_kind(folder / "a.vtk"), ForeignKind::mesh);
  write_file(folder / "a.vtk",
             "# vtk DataFile Version 3.0\nDATASET STRUCTURED_POINTS is only a title\nASCII\nDATASET TABLE\n");
  EXPECT_EQ(foreign_kind(folder / "a.vtk"), ForeignKind::unknown);
  const std::string beginning = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET ";
  write_file(folder / "a.vtk", beginning + "STRUCTURED_GRID\n");
  EXPECT_EQ(foreign_kind(folder / "a.vtk"), ForeignKind::mesh);
  write_file(folder / "a.vtk", beginning + "POLYDATA\n");
  EXPECT_EQ(foreign_kind(folder / "a.vtk"), ForeignKind::surface);
  for (const std::string content :
       {"", "# vtk DataFile Version 3.0", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET", "junk"}) {
    write_file(folder / "a.vtk", content);
    EXPECT_EQ(foreign_kind(folder / "a.vtk"), ForeignKind::unknown);
  }
  EXPECT_EQ(foreign_kind(folder / "none.vtk"), ForeignKind::unknown);
}

}  // namespace
}  // namespace rhoray::preprocess
