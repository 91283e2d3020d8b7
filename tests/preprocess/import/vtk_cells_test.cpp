// Cells of every kind through VTU and legacy VTK files, written by VTK itself, and what is refused
// in them.

#include <vtkNew.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <map>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/readers.h"
#include "tests/preprocess/import/legacy_writer.h"
#include "tests/preprocess/import/vtk_cells.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::ElementsAre;
using testing::HasSubstr;

void write_vtk_xml(vtkDataObject* data, const std::filesystem::path& path,
                   const std::function<void(vtkXMLWriter&)>& set = {}) {
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(data);
  writer->SetFileName(path.c_str());
  if (set) set(*writer);
  ASSERT_EQ(writer->Write(), 1);
}

TEST(VtuCells, come_back_from_every_encoding) {
  TemporaryFolder folder;
  const EveryKind all = every_kind();
  for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
    for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4, vtkXMLWriter::LZMA})
      for (const bool big_endian : {false, true})
        for (const bool wide : {false, true}) {
          SCOPED_TRACE(concat("mode ", mode, " compressor ", compressor, " big ", big_endian, " wide ", wide));
          write_vtk_xml(all.grid, folder / "a.vtu", [&](vtkXMLWriter& writer) {
            writer.SetDataMode(mode);
            writer.SetCompressorType(compressor);
            writer.SetByteOrder(big_endian ? vtkXMLWriter::BigEndian : vtkXMLWriter::LittleEndian);
            writer.SetHeaderType(wide ? vtkXMLWriter::UInt64 : vtkXMLWriter::UInt32);
            writer.SetEncodeAppendedData(wide);
          });
          expect_every_kind(read_cells(folder / "a.vtu", {}), all);
        }
}

TEST(VtuCells, come_back_from_several_pieces_of_one_file) {
  TemporaryFolder folder;
  const EveryKind all = every_kind();
  write_vtk_xml(all.grid, folder / "a.vtu", [](vtkXMLWriter& writer) { writer.SetDataModeToAscii(); });
  const std::string text = read_file(folder / "a.vtu");
  const std::size_t begin = text.find("<Piece"), end = text.find("</Piece>") + 8;
  write_file(folder / "b.vtu", text.substr(0, end) + text.substr(begin, end - begin) + text.substr(end));
  const CellMesh mesh = read_cells(folder / "b.vtu", {});
  ASSERT_EQ(mesh.kinds.size(), 2 * all.kinds.size());
  EXPECT_EQ(mesh.points.size(), 30U);  // the second piece stands where the first one does
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("30 points merged")));
  for (std::size_t cell = 0; cell < mesh.kinds.size(); ++cell)
    EXPECT_EQ(nodes_of(mesh, cell), all.nodes[cell % all.nodes.size()]) << cell;
}

TEST(VtuCells, of_other_pieces_are_left_out_where_they_are_ghosts) {
  TemporaryFolder folder;
  vtkNew<vtkUnstructuredGrid> grid;
  add_points(*grid, 30);
  for (std::uint64_t i = 0; i < 6; ++i) insert(*grid, CellKind::tetrahedron, {i, i + 1, i + 2, i + 3});
  insert(*grid, CellKind::polyhedron, cube_stream(10));
  insert(*grid, static_cast<CellKind>(3), {0, 1});
  add_fields(*grid);
  grid->GetCellData()->AddArray(ghosts({0, 1, 32, 8, 2 | 4 | 16, 0, 0, 0}));
  std::vector<unsigned char> hidden(30, 1);  // a point that is elsewhere too hides nothing
  hidden[8] = 2;
  grid->GetPointData()->AddArray(ghosts(hidden));
  write_vtk_xml(grid, folder / "a.vtu");
  const CellMesh mesh = read_cells(folder / "a.vtu", {});
  EXPECT_THAT(mesh.cell_ids, ElementsAre(0, 4, 6));  // of cell 5 one corner is hidden
  EXPECT_EQ(nodes_of(mesh, 2), cube_stream(10));
  EXPECT_THAT(mesh.cell_fields[0].values, ElementsAre(1, 29, 43));
  EXPECT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(mesh.cell_fields.size(), 1U);
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("1 line left out"), HasSubstr("1 ghost cell"), HasSubstr("1 refined"),
                                      HasSubstr("1 hidden cell"), HasSubstr("1 cell with a hidden point left out")));
}

TEST(LegacyVtkCells, come_back_from_every_version_that_vtk_writes) {
  TemporaryFolder folder;
  const EveryKind all = every_kind();
  for (const int version : {42, 51})
    for (const int file_type : {VTK_ASCII, VTK_BINARY}) {
      SCOPED_TRACE(concat("version ", version, " type ", file_type));
      write_legacy_vtk<vtkUnstructuredGridWriter>(all.grid, folder / "a.vtk", file_type, version);
      CellMesh mesh = read_cells(folder / "a.vtk", {});
      if (version == 42) {
        // Before 5.1 the last two upright edges of a Lagrange hexahedron are the other way round.
        const auto hexahedron = std::find(all.kinds.begin(), all.kinds.end(), CellKind::lagrange_hexahedron);
        const std::size_t cell = static_cast<std::size_t>(hexahedron - all.kinds.begin());
        const std::size_t first = mesh.cell_offsets[cell] + 18;
        EXPECT_EQ(mesh.cell_nodes[first], all.nodes[cell][19]);
        EXPECT_EQ(mesh.cell_nodes[first + 1], all.nodes[cell][18]);
        std::swap(mesh.cell_nodes[first], mesh.cell_nodes[first + 1]);
      }
      expect_every_kind(mesh, all);
    }
}

CellMesh with_points(std::size_t count) {
  CellMesh mesh;
  mesh.points.assign(count, {0, 0, 0});
  return mesh;
}

/// A polyhedron between two tetrahedra, whose stream of faces is this.
void take_polyhedron(const std::vector<std::uint64_t>& stream) {
  CellMesh mesh = with_points(8);
  ForeignCells cells{
      .kinds = {10, 42, 10}, .offsets = {0, 4, 4 + stream.size(), 8 + stream.size()}, .nodes = {0, 1, 2, 3}};
  cells.nodes.insert(cells.nodes.end(), stream.begin(), stream.end());
  for (const std::uint64_t node : {4, 5, 6, 7}) cells.nodes.push_back(node);
  take_cells(mesh, std::move(cells), "a.vtu");
  EXPECT_EQ(nodes_of(mesh, 1), stream);
  EXPECT_EQ(nodes_of(mesh, 2), (std::vector<std::uint64_t>{4, 5, 6, 7}));
}

TEST(PolyhedronStream, is_refused_where_it_is_not_faces) {
  take_polyhedron(cube_stream(0));
  const auto refuses = [](std::vector<std::uint64_t> stream, const std::vector<std::string>& words) {
    expect_refusal([&] { take_polyhedron(stream); }, ErrorCode::invalid, words);
  };
  const auto with = [](std::size_t at, std::uint64_t number) {
    std::vector<std::uint64_t> stream = cube_stream(0);
    stream[at] = number;
    return stream;
  };
  refuses({}, {"polyhedron 1", "no faces"});
  refuses(with(0, 3), {"polyhedron 1", "3 faces", "at least 4"});
  refuses(with(0, 5), {"5 numbers behind its last face"});
  refuses(with(0, 7), {"end of its stream at face 6", "7 faces"});
  refuses(with(0, ~std::uint64_t{0}), {"end of its stream at face 6"});
  refuses(with(1, 2), {"2 corners of face 0"});
  refuses(with(1, ~std::uint64_t{0}), {"-1 corners of face 0", "3 to 29"});
  refuses(with(26, 5), {"5 corners of face 5", "3 to 4"});
  refuses(with(3, 8), {"cell 1", "point 8", "0 to 7"});
  refuses(with(3, ~std::uint64_t{0}), {"cell 1", "point -1"});
  std::vector<std::uint64_t> cut = cube_stream(0);
  for (; cut.size() > 1; cut.pop_back())
    if (cut.size() < 31) refuses(cut, {"polyhedron 1"});
}

TEST(ForeignCells, are_refused_where_ghosts_and_cells_differ_in_number) {
  CellMesh mesh = with_points(4);
  ForeignCells cells{.kinds = {10}, .offsets = {0, 4}, .nodes = {0, 1, 2, 3}, .ghosts = {0, 0}};
  expect_refusal([&] { take_cells(mesh, cells, "a.vtu"); }, ErrorCode::invalid, {"vtkGhostType", "2 numbers"});
  cells.ghosts = {1};
  expect_refusal([&] { take_cells(mesh, cells, "a.vtu"); }, ErrorCode::invalid, {"1 ghost cell left out"});
  cells.ghosts = {};
  cells.point_ghosts = {0, 0, 0};
  expect_refusal([&] { take_cells(mesh, cells, "a.vtu"); }, ErrorCode::invalid, {"vtkGhostType", "3 numbers"});
}

/// A cube as a polyhedron, by hand, with the faces that a file says.
std::string polyhedron_vtu(const std::string& faces, const std::string& face_offsets) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
         "<UnstructuredGrid><Piece NumberOfPoints=\"8\" NumberOfCells=\"1\">\n<Points><DataArray type=\"Float64\" "
         "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 "
         "1</DataArray></Points>\n"
         "<Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 4 5 6 7</DataArray>\n"
         "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">8</DataArray>\n"
         "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">42</DataArray>\n" +
         (faces.empty() ? ""
                        : "<DataArray type=\"Int64\" Name=\"faces\" format=\"ascii\">" + faces +
                              "</DataArray>\n<DataArray type=\"Int64\" Name=\"faceoffsets\" format=\"ascii\">" +
                              face_offsets + "</DataArray>\n") +
         "</Cells></Piece></UnstructuredGrid></VTKFile>\n";
}

TEST(VtuCells, refuse_polyhedra_whose_faces_are_missing_or_damaged) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtu";
  const std::string cube = "6 4 0 3 2 1 4 4 5 6 7 4 0 1 5 4 4 1 2 6 5 4 2 3 7 6 4 3 0 4 7";
  write_file(path, polyhedron_vtu(cube, "31"));
  EXPECT_EQ(nodes_of(read_cells(path, {}), 0), cube_stream(0));
  const auto refuses = [&](const std::string& faces, const std::string& offsets, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    SCOPED_TRACE(faces + " | " + offsets);
    write_file(path, polyhedron_vtu(faces, offsets));
    expect_refusal([&] { read_cells(path, {}); }, error_code, words);
  };
  refuses("", "", ErrorCode::invalid, {"polyhedra without faces"});
  refuses(cube, "-1", ErrorCode::invalid, {"a.vtu"});
  refuses(cube, "32", ErrorCode::invalid, {"a.vtu"});
  refuses("6 4 0 3 2 1 4 4 5 6 7 4 0 1 5 4 4 1 2 6 5 4 2 3 7 6 4 3 0 4 8", "31", ErrorCode::invalid, {"point 8"});
  refuses("3 4 0 3 2 1 4 4 5 6 7 4 0 1 5 4 4 1 2 6 5 4 2 3 7 6 4 3 0 4 7", "31", ErrorCode::invalid, {"a.vtu"});
}

/// A cube as a polyhedron and a tetrahedron, whose arrays of faces are laid out as VTK 9.4 and
/// later have them.
std::string new_polyhedron_vtu(const std::map<std::string, std::string>& arrays) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"2.3\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid><Piece NumberOfPoints=\"8\" NumberOfCells=\"2\">\n<Points><DataArray type=\"Float64\" "
      "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1</DataArray></Points>\n"
      "<Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 4 0 1 2 3 4 5 6 7</DataArray>\n"
      "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 12</DataArray>\n"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 42</DataArray>\n";
  for (const auto& [name, numbers] : arrays)
    text += "<DataArray type=\"Int64\" Name=\"" + name + "\" format=\"ascii\">" + numbers + "</DataArray>\n";
  return text + "</Cells></Piece></UnstructuredGrid></VTKFile>\n";
}

TEST(VtuCells, take_the_faces_of_polyhedra_in_the_layout_of_vtk_9_4) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtu";
  const std::map<std::string, std::string> cube{
      // its faces from the last to the first
      {"face_connectivity", "3 0 4 7  2 3 7 6  1 2 6 5  0 1 5 4  4 5 6 7  0 3 2 1"},
      {"face_offsets", "4 8 12 16 20 24"},
      {"polyhedron_to_faces", "5 4 3 2 1 0"},
      {"polyhedron_offsets", "0 6"}};
  write_file(path, new_polyhedron_vtu(cube));
  const CellMesh mesh = read_cells(path, {});
  EXPECT_EQ(nodes_of(mesh, 0), (std::vector<std::uint64_t>{0, 1, 2, 4}));
  EXPECT_EQ(nodes_of(mesh, 1), cube_stream(0));
  const auto refuses = [&](const std::string& name, const std::string& numbers, const std::vector<std::string>& words) {
    SCOPED_TRACE(name + " " + numbers);
    std::map<std::string, std::string> other = cube;
    other[name] = numbers;
    if (numbers.empty()) other.erase(name);
    write_file(path, new_polyhedron_vtu(other));
    expect_refusal([&] { read_cells(path, {}); }, ErrorCode::invalid, words);
  };
  refuses("face_connectivity", "", {"no array 'face_connectivity'"});
  refuses("face_connectivity", "3 0 4 7  2 3 7 6  1 2 6 5  0 1 5 4  4 5 6 7  0 3 2 8", {"cell 1", "point 8"});
  refuses("face_connectivity", "3 0 4 7", {"a.vtu"});
  refuses("face_offsets", "4 8 12 16 20", {"a.vtu"});
  refuses("face_offsets", "4 2 12 16 20 24", {"polyhedron 1", "that are not there"});
  refuses("face_offsets", "4 8 12 16 20 1000000000000000", {"'face_connectivity'", "1000000000000000 x 1 numbers"});
  refuses("polyhedron_to_faces", "5 4 3 2 1 6", {"a.vtu"});
  refuses("polyhedron_to_faces", "5 4 3 2 1 -1", {"a.vtu"});
  refuses("polyhedron_offsets", "", {"polyhedra without faces"});
  refuses("polyhedron_offsets", "0 3", {"polyhedron 1", "3 faces"});
  refuses("polyhedron_offsets", "7 6", {"polyhedron 1", "that are not there"});
}

TEST(VtuCells, refuse_every_beginning_of_files_with_polyhedra) {
  TemporaryFolder folder;
  const EveryKind all = every_kind();
  for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Appended}) {
    write_vtk_xml(all.grid, folder / "a.vtu", [&](vtkXMLWriter& writer) { writer.SetDataMode(mode); });
    const std::string content = read_file(folder / "a.vtu");
    check_every_beginning(folder / "a.vtu", content,
                          [&] { return read_cells(folder / "a.vtu", {}).kinds.size() == all.kinds.size(); },
                          {.stride = 101, .is_text = mode == vtkXMLWriter::Ascii});
  }
}

}  // namespace
}  // namespace rhoray::preprocess
