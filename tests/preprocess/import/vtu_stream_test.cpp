#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLongLongArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSignedCharArray.h>
#include <vtkUnsignedShortArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "preprocess/import/readers.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/vtk/xml_outline.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

constexpr int point_count = 3000;  // several blocks of VTK's 32 KiB

double place(int point, int axis) {
  return point * 0.37 + axis * 1000 - 1.0 / (1 + point);
}

int number(int owner, int component) {
  return (owner * 7 + component) % 120;
}

template <class Array>
void add_array(vtkFieldData& data, const char* name, vtkIdType owners, int components) {
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(owners);
  for (int i = 0; i < owners; ++i)
    for (int c = 0; c < components; ++c) array->SetComponent(i, c, number(i, c));
  data.AddArray(array);
}

/// Tetrahedra, some hexahedra and triangles among them, with arrays of many types.
vtkSmartPointer<vtkUnstructuredGrid> mixed_grid() {
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int p = 0; p < point_count; ++p) points->InsertNextPoint(place(p, 0), place(p, 1), place(p, 2));
  grid->SetPoints(points);
  for (vtkIdType p = 0; p + 8 <= point_count; ++p) {
    const vtkIdType corners[8] = {p, p + 1, p + 2, p + 3, p + 4, p + 5, p + 6, p + 7};
    if (p % 50 == 17)
      grid->InsertNextCell(VTK_HEXAHEDRON, 8, corners);
    else if (p % 50 == 30)
      grid->InsertNextCell(VTK_TRIANGLE, 3, corners);
    else
      grid->InsertNextCell(VTK_TETRA, 4, corners);
  }
  const vtkIdType cells = grid->GetNumberOfCells();
  add_array<vtkFloatArray>(*grid->GetPointData(), "pressure 1", point_count, 1);
  add_array<vtkDoubleArray>(*grid->GetPointData(), "flow", point_count, 3);
  add_array<vtkSignedCharArray>(*grid->GetPointData(), "bytes", point_count, 1);
  add_array<vtkUnsignedShortArray>(*grid->GetCellData(), "tissue", cells, 2);
  add_array<vtkLongLongArray>(*grid->GetCellData(), "wide", cells, 1);
  add_array<vtkIntArray>(*grid->GetCellData(), "int", cells, 1);
  return grid;
}

void expect_mixed_grid(const CellMesh& mesh) {
  ASSERT_EQ(mesh.points.size(), static_cast<std::size_t>(point_count));
  for (int p = 0; p < point_count; ++p)
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_EQ(mesh.points[static_cast<std::size_t>(p)][static_cast<std::size_t>(axis)], place(p, axis));
  std::size_t cell = 0;
  for (std::uint64_t p = 0; p + 8 <= point_count; ++p) {
    if (p % 50 == 30) continue;  // a triangle
    const bool is_hexahedron = p % 50 == 17;
    ASSERT_EQ(mesh.kinds[cell], is_hexahedron ? CellKind::hexahedron : CellKind::tetrahedron);
    ASSERT_EQ(mesh.cell_ids[cell], p);
    ASSERT_EQ(mesh.cell_offsets[cell + 1] - mesh.cell_offsets[cell], is_hexahedron ? 8U : 4U);
    for (std::uint64_t at = mesh.cell_offsets[cell]; at < mesh.cell_offsets[cell + 1]; ++at)
      ASSERT_EQ(mesh.cell_nodes[at], p + at - mesh.cell_offsets[cell]);
    ASSERT_EQ(mesh.cell_fields.at(0).values[2 * cell + 1], number(static_cast<int>(p), 1));
    ASSERT_EQ(mesh.cell_fields.at(1).values[cell], number(static_cast<int>(p), 0));
    ASSERT_EQ(mesh.cell_fields.at(2).values[cell], number(static_cast<int>(p), 0));
    ++cell;
  }
  EXPECT_EQ(mesh.kinds.size(), cell);
  ASSERT_EQ(mesh.point_fields.size(), 3U);
  EXPECT_EQ(mesh.point_fields[0].name, "pressure 1");
  EXPECT_TRUE(mesh.point_fields[0].was_single_precision);
  EXPECT_EQ(mesh.point_fields[1].component_count, 3);
  EXPECT_FALSE(mesh.point_fields[1].was_single_precision);
  for (std::size_t p = 0; p < point_count; ++p) {
    ASSERT_EQ(mesh.point_fields[0].values[p], number(static_cast<int>(p), 0));
    ASSERT_EQ(mesh.point_fields[1].values[3 * p + 2], number(static_cast<int>(p), 2));
    ASSERT_EQ(mesh.point_fields[2].values[p], number(static_cast<int>(p), 0));
  }
}

class VtuStream : public testing::Test {
 protected:
  std::filesystem::path written(vtkUnstructuredGrid& grid, const std::function<void(vtkXMLWriter&)>& choose) const {
    const auto path = folder_ / "a.vtu";
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    writer->SetInputData(&grid);
    writer->SetFileName(path.c_str());
    choose(*writer);
    if (writer->Write() != 1) throw std::runtime_error("VTK did not write");
    return path;
  }

  TemporaryFolder folder_;
};

TEST_F(VtuStream, reads_every_encoding_that_vtk_writes) {
  const auto grid = mixed_grid();
  int count = 0;
  for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
    for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4, vtkXMLWriter::LZMA})
      for (const bool base64 : {false, true})
        for (const bool wide : {false, true})
          for (const bool big_endian : {false, true}) {
            const auto path = written(*grid, [&](vtkXMLWriter& writer) {
              writer.SetDataMode(mode);
              writer.SetCompressorType(compressor);
              writer.SetEncodeAppendedData(base64);
              writer.SetHeaderType(wide ? vtkXMLWriter::UInt64 : vtkXMLWriter::UInt32);
              writer.SetByteOrder(big_endian ? vtkXMLWriter::BigEndian : vtkXMLWriter::LittleEndian);
            });
            SCOPED_TRACE(concat("mode ", mode, ", compressor ", compressor, base64 ? ", base64" : "",
                                wide ? ", 64-bit headers" : "", big_endian ? ", big-endian" : ""));
            expect_mixed_grid(read_vtu(path));
            ++count;
          }
  EXPECT_EQ(count, 96);
}

/// A tetrahedron and a Lagrange hexahedron of degree 2 on the points 0 to 26, by hand.
std::string old_vtu(const std::string& version, const std::string& point_data) {
  std::string points, corners;
  for (int p = 0; p < 27; ++p) points += concat(p, " 0 0 ");
  for (int p = 0; p < 27; ++p) corners += concat(p, " ");
  const auto array = [](const std::string& attributes, const std::string& content) {
    return "<DataArray format=\"ascii\" " + attributes + ">" + content + "</DataArray>";
  };
  return "<VTKFile type=\"UnstructuredGrid\" version=\"" + version +
         "\"><UnstructuredGrid><Piece NumberOfPoints=\"27\" NumberOfCells=\"2\"><Points>" +
         array("type=\"Float32\" NumberOfComponents=\"3\"", points) + "</Points><Cells>" +
         array("type=\"Int8\" Name=\"connectivity\"", "0 1 2 3 " + corners) +
         array("type=\"Int64\" Name=\"offsets\"", "4 31") + array("type=\"Int32\" Name=\"types\"", "10 72") +
         "</Cells><PointData>" + point_data + "</PointData><CellData>" +
         array("type=\"UInt8\" Name=\"vtkGhostLevels\"", "2 0") + "</CellData></Piece></UnstructuredGrid></VTKFile>";
}

TEST_F(VtuStream, takes_ghost_levels_and_lagrange_cells_by_the_version_of_the_file) {
  write_file(folder_ / "a.vtu", old_vtu("1.0", ""));
  const CellMesh old = read_vtu(folder_ / "a.vtu");
  EXPECT_THAT(old.cell_ids, testing::ElementsAre(1));
  EXPECT_TRUE(old.cell_fields.empty());
  EXPECT_EQ(old.cell_nodes.at(18), 19U);  // the last two upright edges, the other way round
  EXPECT_EQ(old.cell_nodes.at(19), 18U);
  write_file(folder_ / "a.vtu", old_vtu("2.1", ""));
  const CellMesh present = read_vtu(folder_ / "a.vtu");
  EXPECT_EQ(present.kinds.size(), 2U);
  EXPECT_EQ(present.cell_fields.size(), 1U);
  EXPECT_EQ(present.cell_nodes.at(4 + 18), 18U);
}

TEST_F(VtuStream, takes_the_arrays_of_the_first_time_step_with_their_names) {
  const auto array = [](const std::string& step, const std::string& value) {
    std::string values;
    for (int p = 0; p < 27; ++p) values += value + " ";
    return "<DataArray type=\"Float32\" Name=\"gr&#xF6;&#223;e &lt;\" TimeStep=\"" + step + "\">" + values +
           "</DataArray>";
  };
  write_file(folder_ / "a.vtu", old_vtu("2.2", array("1", "5") + array("0 2", "7")));
  const CellMesh mesh = read_vtu(folder_ / "a.vtu");
  ASSERT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(mesh.point_fields[0].name, "gr\u00f6\u00dfe <");
  EXPECT_EQ(mesh.point_fields[0].values[26], 7);
}

TEST_F(VtuStream, refuses_what_it_does_not_know_naming_the_place) {
  const std::string text = old_vtu("1.0", "");
  const auto refuses = [&](const std::string& from, const std::string& to, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    write_file(folder_ / "a.vtu", other);
    expect_refusal([&] { read_vtu(folder_ / "a.vtu"); }, error_code, words);
  };
  refuses("version=\"1.0\"", "compressor=\"x\"", ErrorCode::unsupported, {"attribute compressor", "'x'", "vtkZLib"});
  refuses("version=\"1.0\"", "byte_order=\"x\"", ErrorCode::unsupported, {"attribute byte_order", "BigEndian"});
  refuses("10 72", "10 266", ErrorCode::unsupported, {"kind 255"});
  refuses("</Points>", "", ErrorCode::invalid, {"a.vtu, byte "});
  refuses("NumberOfComponents=\"3\"", "NumberOfComponents=\"x\"", ErrorCode::invalid, {"NumberOfComponents", "'x'"});
  refuses("NumberOfComponents=\"3\"", "", ErrorCode::invalid, {"element Points", "1 numbers for each point"});
  refuses("\"connectivity\"", "\"c\"", ErrorCode::invalid, {"element Cells", "no array 'connectivity'"});
  refuses("format=\"ascii\" type=\"Int8\"", "format=\"appended\" offset=\"9\" type=\"Int8\"", ErrorCode::invalid,
          {"'connectivity'", "offset '9'"});
}

/// The file of the mixed grid, appended, with one of its bytes other than it was.
TEST_F(VtuStream, refuses_damage_naming_the_array) {
  const auto path = written(*mixed_grid(), [](vtkXMLWriter& writer) {
    writer.SetEncodeAppendedData(false);
    writer.SetHeaderType(vtkXMLWriter::UInt64);
  });
  const std::string content = read_file(path);
  const std::size_t data = content.find("<AppendedData");
  const std::size_t first = content.find('_', data) + 1;
  const auto refused = [&](std::size_t at, char value, const std::vector<std::string>& words) {
    std::string damaged = content;
    ASSERT_NE(damaged[at], value);
    damaged[at] = value;
    write_file(path, damaged);
    expect_refusal([&] { read_vtu(path); }, ErrorCode::invalid, words);
  };
  // The first array in the file is the first of the points: blocks, bytes of a block, bytes of the
  // last, packed sizes.
  refused(first, 0, {"a.vtu", "array 'pressure 1'", "0 blocks"});
  refused(first + 15, 0x7f, {"array 'pressure 1'", "blocks of"});
  refused(first + 24 + 5, 1, {"array 'pressure 1'"});
  refused(first + 100, static_cast<char>(~content[first + 100]), {"array 'pressure 1'", "a damaged block"});
  write_file(path, std::string_view(content).substr(0, first + 40));
  expect_refusal([&] { read_cells(path, {}); }, ErrorCode::invalid, {"a.vtu"});
}

TEST_F(VtuStream, takes_no_memory_for_numbers_that_a_short_file_cannot_hold) {
  const std::string text =
      "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">"
      "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 "
      "1</DataArray>"
      "</Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>"
      "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4000000000000</DataArray>"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells></Piece></UnstructuredGrid>"
      "</VTKFile>";
  write_file(folder_ / "a.vtu", text);
  expect_refusal([&] { read_vtu(folder_ / "a.vtu"); }, ErrorCode::invalid,
                 {"'connectivity'", "4000000000000 x 1 numbers"});
}

std::optional<XmlElement> outline(std::string_view text, std::string_view last = "data") {
  std::size_t end = 0;
  std::optional<XmlElement> root = xml_outline(text, last, end);
  EXPECT_LE(end, text.size());
  return root;
}

TEST(XmlOutline, keeps_names_attributes_and_nesting) {
  const auto root =
      outline("<?xml version='1.0'?><!-- <x> --><a b='1 &lt; 2'\n c=\"\"><d/>\n<e f = '\"'> text </e></a>", "none");
  ASSERT_TRUE(root);
  EXPECT_EQ(root->name, "a");
  EXPECT_EQ(root->attribute("b"), "1 < 2");
  EXPECT_EQ(root->attribute("missing"), "");
  ASSERT_EQ(root->children.size(), 2U);
  ASSERT_NE(root->child("e"), nullptr);
  EXPECT_EQ(root->child("e")->content, " text ");
  EXPECT_EQ(root->child("e")->attribute("f"), "\"");
  EXPECT_EQ(root->child("x"), nullptr);
}

TEST(XmlOutline, skips_a_document_type_that_declares_nothing) {
  const auto root = outline("<?xml version='1.0'?><!DOCTYPE a><a b='1'/>");
  ASSERT_TRUE(root);
  EXPECT_EQ(root->attribute("b"), "1");
}

TEST(XmlOutline, leaves_comments_out_of_content) {
  const auto root = outline("<a><b><!-- 1 < 2 --> 3 <!-- --><?and so on?>4<!-- 5 --></b><c>6</c></a>");
  ASSERT_TRUE(root);
  ASSERT_EQ(root->children.size(), 2U);
  EXPECT_EQ(root->child("b")->content, " 3 4");
  EXPECT_EQ(root->child("c")->content, "6");
}

TEST(XmlOutline, does_not_look_behind_the_last_element) {
  const auto root = outline("<a><b/><data kind='raw'>_<<<\0\xff", "data");
  ASSERT_TRUE(root);
  ASSERT_NE(root->child("data"), nullptr);
  EXPECT_EQ(root->child("data")->content.substr(0, 2), "_<");
}

TEST(XmlOutline, says_nothing_about_what_is_not_well_formed) {
  for (const char* text :
       {"", "a", "<", "<a", "<a>", "<a></b>", "<a b></a>", "<a b=1></a>", "<a b='1></a>", "</a>", "<a b='1' b='2'/>",
        "<a b='&other;'/>", "<a b='&#;'/>", "<a b='&#x110000;'/>", "<a b='&#12'/>", "<a><![CDATA[x]]></a>",
        "<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "<!DOCTYPE a", "<!-- "})
    EXPECT_FALSE(outline(text)) << text;
  std::string deep;
  for (int i = 0; i < 1'000'000; ++i) deep += "<a>";
  EXPECT_FALSE(outline(deep));
}

}  // namespace
}  // namespace rhoray::preprocess
