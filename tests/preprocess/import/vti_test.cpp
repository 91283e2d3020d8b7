#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkXMLImageDataWriter.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/vtk_lattice.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

NeutralVolume read(const std::filesystem::path& path, const std::string& field = {}) {
  return read_volume(path, {.raw = {}, .field = field});
}

void write(const std::filesystem::path& path, vtkImageData* image, bool in_text = false) {
  vtkNew<vtkXMLImageDataWriter> writer;
  writer->SetInputData(image);
  writer->SetFileName(path.c_str());
  if (in_text) writer->SetDataModeToAscii();
  ASSERT_EQ(writer->Write(), 1);
}

std::string by_hand(const std::string& extent, const std::string& arrays) {
  return "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"" + extent +
         "\" Origin=\"1 2 3\" Spacing=\"2 3 4\" Direction=\"0 -1 0 1 0 0 0 0 1\"><Piece Extent=\"" + extent + "\">" +
         arrays + "</Piece></ImageData></VTKFile>\n";
}

const std::string known_array =
    "<PointData><DataArray type=\"Int16\" Name=\"v\" format=\"ascii\">" + values_in_text() + "</DataArray></PointData>";

TEST(Vti, reads_what_vtk_writes_in_every_type) {
  TemporaryFolder folder;
  for (const auto& [vtk_type, type] :
       {std::pair(VTK_UNSIGNED_CHAR, ElementType::U8), std::pair(VTK_SHORT, ElementType::I16),
        std::pair(VTK_UNSIGNED_INT, ElementType::U32), std::pair(VTK_LONG_LONG, ElementType::F64),
        std::pair(VTK_FLOAT, ElementType::F32), std::pair(VTK_DOUBLE, ElementType::F64)}) {
    write(folder / "a.vti", vtk_lattice(vtk_type));
    const NeutralVolume volume = read(folder / "a.vti");
    expect_known_values(volume, type);
    EXPECT_EQ(volume.field_name, "density");
  }
}

TEST(Vti, keeps_direction_and_an_extent_that_does_not_begin_at_zero) {
  TemporaryFolder folder;
  write_file(folder / "a.vti", by_hand("10 12 0 3 -1 3", known_array));
  const NeutralVolume volume = read(folder / "a.vti");
  expect_known_values(volume, ElementType::I16);
  // Column x of the direction is (0, 1, 0): the first sample lies 10 steps of 2 along it, and one
  // of 4 back along z.
  expect_map(volume.world_from_grid, {{0, 2, 0}, {-3, 0, 0}, {0, 0, 4}, {1, 22, -1}});
}

TEST(Vti, picks_a_component_or_the_length_of_vectors) {
  TemporaryFolder folder;
  const vtkSmartPointer<vtkImageData> image = vtk_lattice(VTK_FLOAT);
  image->GetPointData()->GetScalars()->SetName("density");
  vtkNew<vtkFloatArray> flow;
  flow->SetName("flow");
  flow->SetNumberOfComponents(3);
  for (std::size_t i = 0; i < value_count; ++i)
    flow->InsertNextTuple3(static_cast<double>(i), 2, static_cast<double>(i) * 2);
  image->GetPointData()->AddArray(flow);
  write(folder / "a.vti", image);
  EXPECT_EQ(read(folder / "a.vti").field_name, "density");
  EXPECT_EQ(values_of(read(folder / "a.vti", "flow.x"))[7], 7);
  EXPECT_EQ(values_of(read(folder / "a.vti", "flow.z"))[7], 14);
  EXPECT_EQ(values_of(read(folder / "a.vti", "flow.mag"))[1], 3);  // 1, 2, 2
  EXPECT_EQ(read(folder / "a.vti", "flow.mag").field_name, "flow.mag");
  expect_refusal([&] { read(folder / "a.vti", "flow"); }, ErrorCode::usage, {"field 'flow'", "3 components"});
  expect_refusal([&] { read(folder / "a.vti", "flow.3"); }, ErrorCode::usage,
                 {"no field 'flow.3'", "density, flow.mag, flow.x, flow.y, flow.z"});
  expect_refusal([&] { read(folder / "a.vti", "flo"); }, ErrorCode::usage, {"no field 'flo'"});
}

TEST(Vti, shows_the_magnitude_of_several_components_without_a_choice) {
  TemporaryFolder folder;
  write_file(folder / "a.vti", by_hand("0 0 0 0 0 1",
                                       "<PointData><DataArray type=\"UInt8\" Name=\"rgba\" NumberOfComponents=\"4\" "
                                       "format=\"ascii\">1 2 3 4 5 6 7 8</DataArray></PointData>"));
  EXPECT_EQ(read(folder / "a.vti").field_name, "rgba.mag");
  EXPECT_THAT(values_of(read(folder / "a.vti", "rgba.3")), testing::ElementsAre(4, 8));
}

TEST(Vti, shows_the_magnitude_of_the_first_vector_where_nothing_is_scalar) {
  TemporaryFolder folder;
  const std::string flow =
      "<PointData><DataArray type=\"Int16\" Name=\"flow\" NumberOfComponents=\"2\" format=\"ascii\">3 4 5 12"
      "</DataArray>";
  const std::string turn =
      "<DataArray type=\"UInt8\" Name=\"turn\" NumberOfComponents=\"3\" format=\"ascii\">1 2 2 4 4 2</DataArray>";
  write_file(folder / "a.vti", by_hand("0 0 0 0 0 1", flow + turn + "</PointData>"));
  const NeutralVolume volume = read_volume(folder / "a.vti", {.raw = {}, .field = {}});
  EXPECT_EQ(volume.field_name, "flow.mag");
  EXPECT_THAT(values_of(volume), testing::ElementsAre(5, 13));
  ASSERT_EQ(volume.vectors.size(), 2U);
  EXPECT_EQ(volume.vectors[0].name, "flow");
  EXPECT_EQ(volume.vectors[0].component_count, 2);
  EXPECT_EQ(volume.vectors[1].name, "turn");
  EXPECT_EQ(volume.vectors[1].component_count, 3);
  EXPECT_THAT(volume.notes,
              testing::ElementsAre("using the magnitude of 2 components, 'flow.mag'; choose another with --field: "
                                   "flow.x, flow.y, turn.mag, turn.x, turn.y, turn.z"));

  const std::string one = "<DataArray type=\"UInt8\" Name=\"one\" format=\"ascii\">7 9</DataArray>";
  write_file(folder / "a.vti", by_hand("0 0 0 0 0 1", flow + one + "</PointData>"));
  const NeutralVolume scalar = read_volume(folder / "a.vti", {.raw = {}, .field = {}});
  EXPECT_EQ(scalar.field_name, "one");
  EXPECT_THAT(scalar.notes, testing::ElementsAre("using 'one'; choose another with --field: flow.mag, flow.x, flow.y"));
  EXPECT_TRUE(scalar.other_fields.empty()) << "a vector is none that --field takes";
  ASSERT_EQ(scalar.vectors.size(), 1U);
}

TEST(Vti, puts_values_of_cells_at_their_middles) {
  TemporaryFolder folder;
  write_file(folder / "a.vti", by_hand("0 2 0 1 0 1",
                                       "<CellData><DataArray type=\"Float64\" Name=\"c\" format=\"ascii\">5 6"
                                       "</DataArray></CellData>"));
  const NeutralVolume volume = read(folder / "a.vti");
  EXPECT_EQ(volume.sample_count, Index3(2, 1, 1));
  EXPECT_THAT(values_of(volume), testing::ElementsAre(5, 6));
  expect_near(volume.world_from_grid.origin, {1 - 1.5, 2 + 1, 3 + 2});
  EXPECT_EQ(volume.notes.size(), 1U);
}

std::string array_by_hand(const std::string& type, const std::string& name, const std::string& content) {
  return concat("<DataArray type=\"", type, "\" Name=\"", name, "\" format=\"ascii\">", content, "</DataArray>");
}

TEST(Vti, keeps_the_unit_and_passes_over_comments) {
  TemporaryFolder folder;
  const std::string key = "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">mmHg</InformationKey>";
  write_file(folder / "a.vti",
             by_hand("0 2 0 3 0 4", "<PointData>" +
                                        array_by_hand("Int16", "v", "<!-- 60 numbers -->" + values_in_text() + key) +
                                        "</PointData>"));
  const NeutralVolume volume = read(folder / "a.vti");
  expect_known_values(volume, ElementType::I16);
  EXPECT_EQ(volume.field_unit, "mmHg");
}

/// VTK hides points and cells by the array vtkGhostType; it is no field.
TEST(Vti, takes_values_of_hidden_points_and_cells_as_no_data) {
  TemporaryFolder folder;
  std::string points, cells, values;
  for (int i = 0; i < 27; ++i) points += i == 1 ? "2 " : "0 ";
  for (int i = 0; i < 8; ++i) cells += i == 7 ? "32 " : "0 ", values += concat(i, " ");
  std::string numbers;
  for (int i = 0; i < 27; ++i) numbers += concat(i, " ");
  write_file(folder / "a.vti",
             by_hand("0 2 0 2 0 2", "<PointData>" + array_by_hand("UInt8", "vtkGhostType", points) +
                                        array_by_hand("Int16", "v", numbers) + "</PointData><CellData>" +
                                        array_by_hand("UInt8", "vtkGhostType", cells) +
                                        array_by_hand("Float64", "c", values) + "</CellData>"));
  const NeutralVolume volume = read(folder / "a.vti");
  EXPECT_EQ(volume.field_name, "v");
  EXPECT_THAT(volume.other_fields, testing::ElementsAre("c"));
  EXPECT_EQ(volume.type, ElementType::F32);
  for (std::size_t i = 0; i < 27; ++i)
    EXPECT_TRUE(i == 1 ? std::isnan(values_of(volume)[i]) : values_of(volume)[i] == static_cast<double>(i)) << i;
  EXPECT_THAT(volume.notes, testing::Contains("1 hidden point has no data"));
  const NeutralVolume in_cells = read(folder / "a.vti", "c");  // point 1 is a corner of the cells 0 and 1
  EXPECT_THAT(values_of(in_cells),
              testing::ElementsAre(testing::IsNan(), testing::IsNan(), 2, 3, 4, 5, 6, testing::IsNan()));
  EXPECT_THAT(in_cells.notes, testing::Contains("3 hidden cells, or cells with a hidden point, have no data"));
  expect_refusal([&] { read(folder / "a.vti", "vtkGhostType"); }, ErrorCode::usage, {"expected one of: v, c"});
}

TEST(Vti, notes_numbers_after_the_last) {
  TemporaryFolder folder;
  write_file(folder / "a.vti",
             by_hand("0 2 0 3 0 4",
                     "<PointData>" + array_by_hand("Int16", "v", values_in_text() + " 98 97\n") + "</PointData>"));
  const NeutralVolume volume = read(folder / "a.vti");
  expect_known_values(volume, ElementType::I16);
  EXPECT_THAT(volume.notes, testing::Contains("array 'v': 2 words after its numbers were left out"));
}

TEST(Vti, refuses_other_files_and_absurd_sizes) {
  TemporaryFolder folder;
  const auto path = folder / "a.vti";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read(path); }, error_code, words);
  };
  refuses("not XML at all", ErrorCode::invalid, {"a.vti", "VTKFile"});
  refuses("<VTKFile type=\"PolyData\"></VTKFile>", ErrorCode::unsupported, {"'PolyData'", "ImageData"});
  refuses(by_hand("0 2 0 3 0 4", ""), ErrorCode::invalid, {"no values"});
  refuses(by_hand("0 99999 0 99999 0 99", known_array), ErrorCode::invalid, {"WholeExtent", "1000000000000 in"});
  refuses(by_hand("0 2 0 3 0 5", known_array), ErrorCode::invalid, {"a.vti"});
  refuses(by_hand("0 2 3 0 0 5", known_array), ErrorCode::invalid, {"WholeExtent"});
}

TEST(Vti, is_read_in_every_encoding) {
  TemporaryFolder folder;
  for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
    for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4, vtkXMLWriter::LZMA})
      for (const bool big_endian : {false, true}) {
        vtkNew<vtkXMLImageDataWriter> writer;
        writer->SetInputData(vtk_lattice(VTK_SHORT));
        writer->SetFileName((folder / "a.vti").c_str());
        writer->SetDataMode(mode);
        writer->SetCompressorType(compressor);
        if (big_endian) writer->SetByteOrderToBigEndian();
        ASSERT_EQ(writer->Write(), 1);
        expect_known_values(read(folder / "a.vti"), ElementType::I16);
      }
}

/// The lattice in two pieces that share a layer of points, with values of cells too.
TEST(Vti, is_put_together_from_pieces_that_cover_it) {
  TemporaryFolder folder;
  const auto piece = [](int first_k, int last_k) {
    std::string points, cells;
    for (int k = first_k; k <= last_k; ++k)
      for (int j = 0; j < size_y; ++j)
        for (int i = 0; i < size_x; ++i) {
          points += concat(value_at(i, j, k), " ");
          if (i + 1 < size_x && j + 1 < size_y && k < last_k) cells += concat(value_at(i, j, k), " ");
        }
    return concat("<Piece Extent=\"5 ", size_x + 4, " 0 ", size_y - 1, " ", first_k, " ", last_k,
                  "\"><PointData><DataArray type=\"Int16\" Name=\"v\" format=\"ascii\">", points,
                  "</DataArray></PointData><CellData><DataArray type=\"Int16\" Name=\"c\" format=\"ascii\">", cells,
                  "</DataArray></CellData></Piece>");
  };
  const auto write_pieces = [&](const std::string& pieces) {
    write_file(folder / "a.vti",
               concat("<VTKFile type=\"ImageData\" version=\"0.1\"><ImageData WholeExtent=\"5 ", size_x + 4, " 0 ",
                      size_y - 1, " 0 ", size_z - 1, "\">", pieces, "</ImageData></VTKFile>"));
  };
  write_pieces(piece(2, size_z - 1) + piece(0, 2));
  const NeutralVolume volume = read(folder / "a.vti");
  EXPECT_EQ(values_of(volume), known_values<double>());
  EXPECT_EQ(volume.world_from_grid.origin, Vec3(5, 0, 0));
  const std::vector<double> cells = values_of(read(folder / "a.vti", "c"));
  ASSERT_EQ(cells.size(), static_cast<std::size_t>((size_x - 1) * (size_y - 1) * (size_z - 1)));
  for (std::size_t at = 0; at < cells.size(); ++at) {
    const auto cell = static_cast<std::int64_t>(at), row = cell / (size_x - 1);
    EXPECT_EQ(cells[at], value_at(cell % (size_x - 1), row % (size_y - 1), row / (size_y - 1))) << at;
  }
  std::string other = piece(2, size_z - 1);
  other.replace(other.find("\"c\""), 3, "\"d\"");
  write_pieces(piece(0, 2) + other);
  expect_refusal([&] { read(folder / "a.vti"); }, ErrorCode::invalid, {"element CellData", "other arrays"});
  write_pieces(piece(0, 2));
  expect_refusal([&] { read(folder / "a.vti"); }, ErrorCode::invalid, {"1 pieces that do not make up"});
}

TEST(Vti, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const auto is_complete = [&] {
    const NeutralVolume volume = read(folder / "a.vti");
    return values_of(volume) == known_values<double>();
  };
  const std::string text = by_hand("0 2 0 3 0 4", known_array);
  check_every_beginning(folder / "a.vti", text, is_complete, {.stride = 7});
  write(folder / "b.vti", vtk_lattice(VTK_DOUBLE));
  check_every_beginning(folder / "a.vti", read_file(folder / "b.vti"), is_complete, {.stride = 7});
}

}  // namespace
}  // namespace rhoray::preprocess
