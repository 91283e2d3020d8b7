// Meshes in XDMF files. Text is written here, HDF5 by its library. The expected meshes are those
// that the same numbers give as VTU and VTS, written by VTK. Documents as FEniCS, dolfinx, meshio
// and XDMF's own library write them are made by hand after files of these programs.
#include <vtkNew.h>
#include <vtkStructuredGrid.h>
#include <vtkXMLStructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <numeric>

#include "preprocess/import/readers.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/vtk_cells.h"
#include "tests/preprocess/import/xdmf_files.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class Xdmf : public XdmfMeshes {};

void expect_same(const CellMesh& found, const CellMesh& expected) {
  EXPECT_EQ(found.points, expected.points);
  EXPECT_EQ(found.kinds, expected.kinds);
  EXPECT_EQ(found.cell_offsets, expected.cell_offsets);
  EXPECT_EQ(found.cell_nodes, expected.cell_nodes);
  EXPECT_EQ(found.cell_ids, expected.cell_ids);
  for (const auto fields : {&CellMesh::point_fields, &CellMesh::cell_fields}) {
    ASSERT_EQ((found.*fields).size(), (expected.*fields).size());
    for (std::size_t i = 0; i < (found.*fields).size(); ++i) {
      EXPECT_EQ((found.*fields)[i].name, (expected.*fields)[i].name);
      EXPECT_EQ((found.*fields)[i].component_count, (expected.*fields)[i].component_count);
      EXPECT_EQ((found.*fields)[i].values, (expected.*fields)[i].values);
    }
  }
}

/// A kind of cells in XDMF: name, number, VTK's kind, nodes.
struct Kind {
  const char* name;
  int number, vtk;
  int nodes;
};
constexpr Kind kinds_of_xdmf[] = {{"Triangle", 4, 5, 3},
                                  {"Quadrilateral", 5, 9, 4},
                                  {"Tetrahedron", 6, 10, 4},
                                  {"Pyramid", 7, 14, 5},
                                  {"Wedge", 8, 13, 6},
                                  {"Hexahedron", 9, 12, 8},
                                  {"Edge_3", 34, 21, 3},
                                  {"Quad_9", 35, 28, 9},
                                  {"Tri_6", 36, 22, 6},
                                  {"Quad_8", 37, 23, 8},
                                  {"Tet_10", 38, 24, 10},
                                  {"Pyramid_13", 39, 27, 13},
                                  {"Wedge_15", 40, 26, 15},
                                  {"Wedge_18", 41, 32, 18},
                                  {"Hex_20", 48, 25, 20},
                                  {"Hex_24", 49, 33, 24},
                                  {"Hex_27", 50, 29, 27},
                                  {"Tetrahedron_10", 38, 24, 10},
                                  {"Hexahedron_20", 48, 25, 20},
                                  {"Hexahedron_24", 49, 33, 24},
                                  {"Hexahedron_27", 50, 29, 27},
                                  {"Triangle_6", 36, 22, 6},
                                  {"Quadrilateral_8", 37, 23, 8},
                                  {"Quadrilateral_9", 35, 28, 9}};

/// All kinds in one grid of 30 points, and the numbers of a Mixed topology for it.
struct EveryKindOfXdmf {
  vtkSmartPointer<vtkUnstructuredGrid> grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  std::vector<std::uint64_t> mixed;
  std::size_t count = 0;

  EveryKindOfXdmf() {
    add_points(*grid, 30);
    const auto add = [&](int vtk, const std::vector<std::uint64_t>& before, const std::vector<std::uint64_t>& nodes) {
      insert(*grid, static_cast<CellKind>(vtk), nodes);
      mixed.insert(mixed.end(), before.begin(), before.end());
      mixed.insert(mixed.end(), nodes.begin(), nodes.end());
      ++count;
    };
    for (const Kind& kind : kinds_of_xdmf) {
      std::vector<std::uint64_t> nodes;
      for (int i = 0; i < kind.nodes; ++i) nodes.push_back(static_cast<std::uint64_t>((kind.vtk + i) % 30));
      add(kind.vtk, {static_cast<std::uint64_t>(kind.number)}, nodes);
    }
    add(2, {1, 1}, {7});  // of each: number of nodes
    add(4, {2, 2}, {3, 4});
    add(7, {3, 5}, {1, 2, 3, 4, 5});
    add(42, {16}, cube_stream(9));
    add_fields(*grid);
  }

  /// Points and fields, as text.
  std::string rest() const {
    std::vector<double> points, at_points(30), in_cells(count);
    for (int i = 0; i < 30; ++i) {
      points.insert(points.end(), {grid->GetPoint(i)[0], grid->GetPoint(i)[1], grid->GetPoint(i)[2]});
      at_points[static_cast<std::size_t>(i)] = 100 * i;
    }
    for (std::size_t i = 0; i < count; ++i) in_cells[i] = 7 * static_cast<double>(i) + 1;
    return geometry(item("30 3", in_words(points))) + attribute("v", item("30", in_words(at_points))) +
           attribute("c", item(concat(count), in_words(in_cells), "NumberType=\"Int\""), "Cell");
  }
};

TEST_F(Xdmf, reads_mixed_cells_of_every_kind_as_from_vtu) {
  const EveryKindOfXdmf all;
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(all.grid);
  writer->SetFileName((folder_ / "a.vtu").c_str());
  ASSERT_EQ(writer->Write(), 1);
  const std::string numbers = item(concat(all.mixed.size()), in_words(all.mixed), "NumberType=\"Int\"");
  const CellMesh expected = read_cells(folder_ / "a.vtu", {});
  EXPECT_EQ(expected.kinds.size(), 16U);  // those that fill space
  for (const std::string& more : {concat("NumberOfElements=\"", all.count, "\""), std::string()}) {
    const CellMesh mesh = read(xdmf(grid("a", topology("Mixed", numbers, more) + all.rest())));
    expect_same(mesh, expected);
    EXPECT_TRUE(mesh.point_fields[0].was_single_precision);
    EXPECT_THAT(mesh.notes, Contains(HasSubstr("left out: only cells that fill space")));
  }
}

TEST_F(Xdmf, reads_cells_of_one_kind_by_all_its_names) {
  for (const Kind& kind : kinds_of_xdmf) {
    std::vector<int> nodes(2 * static_cast<std::size_t>(kind.nodes));
    std::iota(nodes.begin(), nodes.end(), 0);
    const std::string points = geometry(item("60 3", in_words(std::vector<int>(180, 1))));
    const std::string cells = item(concat("2 ", kind.nodes), in_words(nodes), "NumberType=\"UInt\" Precision=\"8\"");
    const bool is_flat = std::string(kind.name)[0] == 'Q' || std::string(kind.name).starts_with("Tri") ||
                         std::string(kind.name).starts_with("Edge");
    for (const std::string& text :
         {topology(kind.name, cells, "NumberOfElements=\"2\""), topology(kind.name, cells, "Dimensions=\"2\""),
          concat("<Topology Type=\"", kind.name, "\">\n", cells, "</Topology>\n")}) {
      if (is_flat) {
        expect_refusal([&] { read(xdmf(grid("a", text + points))); }, ErrorCode::invalid,
                       {"a.xdmf, cells: found 2", "expected at least one that fills space"});
        continue;
      }
      const CellMesh mesh = read(xdmf(grid("a", text + points)));
      ASSERT_EQ(mesh.kinds.size(), 2U) << kind.name;
      EXPECT_EQ(static_cast<int>(mesh.kinds[1]), kind.vtk);
      EXPECT_EQ(mesh.cell_nodes, Array<std::uint64_t>(nodes.begin(), nodes.end()));
    }
  }
}

TEST_F(Xdmf, leaves_out_points_without_a_list_and_polylines) {
  const std::string loose = topology("Polyvertex", "", "NumberOfElements=\"4\" NodesPerElement=\"1\"");
  const std::string lines = topology("PolyLine", item("1 2", "0 1", "NumberType=\"Int\""), "NodesPerElement=\"2\"");
  for (const std::string& cells : {loose, lines})
    expect_refusal([&] { read(xdmf(grid("a", cells + tet_points))); }, ErrorCode::invalid,
                   {"at least one that fills space"});
  const CellMesh mesh =
      read(xdmf(collection("all", "Spatial", grid("a", tet_cells + tet_points) + grid("b", loose + tet_points))));
  EXPECT_EQ(mesh.kinds.size(), 1U);
  EXPECT_EQ(mesh.points.size(), 4U);
  EXPECT_THAT(mesh.notes, Contains(HasSubstr("4 vertices left out")));
}

TEST_F(Xdmf, reads_points_of_every_type) {
  const auto points = [&](const std::string& text) { return read(xdmf(grid("a", tet_cells + text))).points; };
  const Array<std::array<double, 3>> solid{{0, 0, 0}, {1, 0, 0.25}, {0, 1, 0}, {0, 0, 1}},
      flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 6, 0}};
  EXPECT_EQ(points(geometry(item("4 3", "0 0 0 1 0 0.25 0 1 0 0 0 1"))), solid);
  EXPECT_EQ(points("<Geometry>\n" + item("12", "0 0 0 1 0 0.25 0 1 0 0 0 1") + "</Geometry>\n"), solid);
  EXPECT_EQ(points("<Geometry Type=\"X_Y_Z\">\n" + item("4", "0 1 0 0") + item("4", "0 0 1 0") +
                   item("4", "0 0.25 0 1") + "</Geometry>\n"),
            solid);
  EXPECT_EQ(points(geometry(item("4 2", "0 0 1 0 0 1 5 6"), "XY")), flat);
  EXPECT_EQ(points(geometry(item("4", "0 1 0 5") + item("4", "0 0 1 6"), "x_y")), flat);
}

TEST_F(Xdmf, takes_the_base_offset_from_nodes_that_count_from_one) {
  const std::string numbers = item("4", "1 2 3 4", "NumberType=\"Int\"");
  EXPECT_THAT(read(xdmf(grid("a", topology("Tetrahedron", numbers, "BaseOffset=\"1\"") + tet_points))).cell_nodes,
              ElementsAre(0, 1, 2, 3));
  const std::string mixed = item("5", "6 1 2 3 4", "NumberType=\"Int\"");
  EXPECT_THAT(read(xdmf(grid("a", topology("Mixed", mixed, "BaseOffset=\"1\"") + tet_points))).cell_nodes,
              ElementsAre(0, 1, 2, 3));
  expect_refusal([&] { read(xdmf(grid("a", topology("Tetrahedron", numbers) + tet_points))); }, ErrorCode::invalid,
                 {"cell 0: found point 4; expected 0 to 3"});
}

/// The two tetrahedra of a pyramid, with a field of each type.
void write_pyramid(const std::filesystem::path& path, hid_t real, hid_t integer, const std::vector<hsize_t>& chunk) {
  const Hdf5Writer file(path);
  const auto chunked = [&](std::vector<hsize_t> own) { return chunk.empty() ? chunk : own; };
  file.array("/Mesh/0/points", real, {5, 3}, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 1}, chunked({2, 3}));
  file.array("/Mesh/0/cells", integer, {2, 4}, {0, 1, 2, 4, 0, 2, 3, 4}, chunked({1, 4}));
  file.array("/u", real, {5, 1}, {1, 2, 3, 4, 0.5}, chunked({5, 1}));
  file.array(
      "/all", real, {2, 5, 3},
      [] {
        std::vector<double> numbers(30);
        std::iota(numbers.begin(), numbers.end(), 0);
        return numbers;
      }(),
      chunked({1, 5, 1}));
}

std::string pyramid(const std::string& attributes, const std::string& file = "data.h5") {
  return xdmf(
      grid("a", topology("Tetrahedron", item("2 4", file + ":/Mesh/0/cells", "Format=\"HDF\" NumberType=\"Int\""),
                         "NumberOfElements=\"2\" NodesPerElement=\"4\"") +
                    geometry(item("5 3", "\n   " + file + ":/Mesh/0/points\n  ", "Format=\"HDF\"")) + attributes));
}

TEST_F(Xdmf, reads_hdf5_of_every_type_packed_or_not) {
  std::filesystem::create_directory(folder_ / "heavy");
  for (const hid_t real : {H5T_IEEE_F64LE, H5T_IEEE_F32BE})
    for (const hid_t integer : {H5T_STD_I32LE, H5T_STD_U64BE, H5T_STD_I8LE, H5T_STD_U16LE})
      for (const std::vector<hsize_t>& chunk : {std::vector<hsize_t>(), std::vector<hsize_t>{1}}) {
        write_pyramid(folder_ / "heavy/data.h5", real, integer, chunk);
        const std::string file = "heavy/data.h5";
        const CellMesh mesh = read(pyramid(attribute("u", item("5 1", file + ":u", "Format=\"HDF\"")), file));
        EXPECT_EQ(mesh.points[4], (std::array{0.5, 0.5, 1.0}));
        EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 2, 4, 0, 2, 3, 4));
        EXPECT_THAT(mesh.point_fields.at(0).values, ElementsAre(1, 2, 3, 4, 0.5));
        EXPECT_EQ(mesh.point_fields[0].was_single_precision, H5Tequal(real, H5T_IEEE_F32BE) > 0);
      }
}

TEST_F(Xdmf, reads_parts_of_arrays) {
  write_pyramid(folder_ / "data.h5", H5T_IEEE_F64LE, H5T_STD_I32LE, {});
  const std::string part = item("3 3", "1 0 1  1 1 1  1 5 1", "NumberType=\"Int\"");
  const std::string strided = item("3 3", "0 0 0  1 2 2  1 3 2", "NumberType=\"Int\"");
  const auto slab = [&](const std::string& selection, const std::string& whole) {
    return concat("<DataItem ItemType=\"HyperSlab\">\n", selection, whole, "</DataItem>\n");
  };
  std::vector<double> numbers(30);
  std::iota(numbers.begin(), numbers.end(), 0);
  write_file(folder_ / "data.bin", bytes_of_values(numbers));
  for (const std::string& source : {item("2 5 3", "data.h5:/all", "Format=\"HDF\""), item("2 5 3", in_words(numbers)),
                                    item("2 5 3", "data.bin", "Format=\"Binary\" Precision=\"8\"")}) {
    EXPECT_THAT(read(pyramid(attribute("a", slab(part, source)))).point_fields.at(0).values,
                ElementsAre(16, 19, 22, 25, 28));
    const CellMesh mesh = read(pyramid(attribute("a", slab(strided, source), "Cell", "Vector")));
    EXPECT_EQ(mesh.cell_fields.at(0).component_count, 3);
    EXPECT_THAT(mesh.cell_fields[0].values, ElementsAre(0, 2, 6, 8, 12, 14));
  }
  const std::string in_name = item("5", "data.h5:/all|1 0 1:1 1 1:1 5 1:2 5 3", "Format=\"HDF\"");
  EXPECT_THAT(read(pyramid(attribute("a", in_name))).point_fields.at(0).values, ElementsAre(16, 19, 22, 25, 28));
}

TEST_F(Xdmf, reads_binary_numbers_in_both_byte_orders) {
  const auto fields = [&]<class T>(T, const std::string& words) {
    const std::vector<T> values{T(1), T(2), T(100), T(4)};
    for (const std::string order : {"Little", "Big", "Native"}) {
      write_file(folder_ / "a.bin", "skipped" + bytes_of_values(values, order == "Big") + "rest");
      const std::string numbers =
          item("4", " a.bin\n", concat("Format=\"Binary\" Seek=\"7\" Endian=\"", order, "\" ", words));
      const CellMesh mesh = read(xdmf(grid("a", tet_cells + tet_points + attribute("f", numbers))));
      EXPECT_THAT(mesh.point_fields.at(0).values, ElementsAre(1, 2, 100, 4)) << words << order;
    }
  };
  fields(float{}, "");
  fields(float{}, "NumberType=\"Float\" Precision=\"4\" Compression=\"Raw\"");
  fields(double{}, "DataType=\"Float\" Precision=\"8\"");
  fields(double{}, "NumberType=\"Double\"");
  fields(std::int8_t{}, "NumberType=\"Char\"");
  fields(std::uint8_t{}, "NumberType=\"UChar\" Precision=\"1\"");
  fields(std::int8_t{}, "NumberType=\"Int\" Precision=\"1\"");
  fields(std::int16_t{}, "NumberType=\"Short\"");
  fields(std::uint16_t{}, "NumberType=\"UInt\" Precision=\"2\"");
  fields(std::int32_t{}, "NumberType=\"Int\"");
  fields(std::uint32_t{}, "NumberType=\"UInt\" Precision=\"4\"");
  fields(std::int64_t{}, "NumberType=\"Int\" Precision=\"8\"");
  fields(std::uint64_t{}, "NumberType=\"UInt\" Precision=\"8\"");
}

TEST_F(Xdmf, keeps_the_digits_of_text_as_its_precision_says) {
  const auto value = [&](const std::string& more) {
    return read(xdmf(grid("a", tet_cells + tet_points + attribute("f", item("4", "0.1 0 0 0", more)))))
        .point_fields.at(0)
        .values[0];
  };
  EXPECT_EQ(value("Precision=\"8\""), 0.1);
  EXPECT_EQ(value(""), 0.1);
  EXPECT_EQ(value("Precision=\"4\""), static_cast<double>(0.1F));
}

TEST_F(Xdmf, reads_scalars_vectors_and_tensors_by_the_common_rule) {
  const auto numbers = [](int each) {
    std::vector<int> all(4 * static_cast<std::size_t>(each));
    std::iota(all.begin(), all.end(), 0);
    return item(concat("4 ", each), in_words(all));
  };
  const CellMesh mesh = read(xdmf(
      grid("a", tet_cells + tet_points + attribute("s", numbers(1)) + attribute("v", numbers(3), "Node", "Vector") +
                    attribute("flat", numbers(2), "Node", "Vector") + attribute("t", numbers(9), "Node", "Tensor") +
                    attribute("sym", numbers(6), "Node", "Tensor6") + attribute("m", numbers(4), "Node", "Matrix") +
                    attribute("six", numbers(6), "Node", "Matrix"))));
  std::vector<std::pair<std::string, int>> found;
  for (const NeutralField& field : mesh.point_fields) found.emplace_back(field.name, field.component_count);
  EXPECT_THAT(found, ElementsAre(std::pair("s", 1), std::pair("v", 3), std::pair("flat", 2), std::pair("t", 9),
                                 std::pair("sym", 6), std::pair("m", 4), std::pair("six", 6)));
  // xx xy xz yy yz zz become xx yy zz xy yz xz; six numbers of a matrix stay
  const Array<double>&sym = mesh.point_fields[4].values, six = mesh.point_fields[6].values;
  EXPECT_THAT(std::vector(sym.begin(), sym.begin() + 12), ElementsAre(0, 3, 5, 1, 4, 2, 6, 9, 11, 7, 10, 8));
  EXPECT_THAT(std::vector(six.begin(), six.begin() + 6), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST_F(Xdmf, notes_attributes_that_it_leaves_out) {
  const std::string one = item("4", "1 2 3 4");
  const CellMesh mesh = read(xdmf(grid(
      "a", tet_cells + tet_points + attribute("kept", one) + attribute("kept", one) + attribute("faces", one, "Face") +
               attribute("whole", item("1", "1"), "Grid") +
               "<Attribute ItemType=\"FiniteElementFunction\" Name=\"dofs\" Center=\"Other\" ElementFamily=\"CG\">" +
               one + one + "</Attribute>\n" +
               attribute("sum", "<DataItem ItemType=\"Function\" Function=\"$0 + $1\" Dimensions=\"4\">" + one + one +
                                    "</DataItem>\n"))));
  EXPECT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_THAT(mesh.notes,
              ElementsAre("attribute 'kept' left out: another has the same name",
                          "attribute 'faces' left out: its values stand at 'face', not at nodes or in cells",
                          "attribute 'whole' left out: its values stand at 'grid', not at nodes or in cells",
                          "attribute 'dofs' left out: its values stand at 'other', not at nodes or in cells",
                          "attribute 'sum' left out: a function computes it"));
}

TEST_F(Xdmf, leaves_out_the_ghost_cells_of_paraview) {
  const std::string cells = topology("Tetrahedron", item("2 4", "0 1 2 3 0 2 1 3", "NumberType=\"Int\""));
  const CellMesh mesh = read(xdmf(
      grid("a", cells + tet_points + attribute("vtkGhostType", item("2", "0 1", "NumberType=\"UChar\""), "Cell"))));
  EXPECT_EQ(mesh.kinds.size(), 1U);
  EXPECT_THAT(mesh.notes, Contains(HasSubstr("1 ghost cell left out")));
}

TEST_F(Xdmf, reads_a_structured_grid_as_from_vts) {
  vtkNew<vtkStructuredGrid> curved;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  std::vector<double> places, values;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 2; ++i) {
        points->InsertNextPoint(i + 0.1 * j, j + 0.1 * k * k, k);
        places.insert(places.end(), {i + 0.1 * j, j + 0.1 * k * k, static_cast<double>(k)});
        values.push_back(i + 10 * j + 100 * k);
      }
  curved->SetDimensions(2, 3, 4);
  curved->SetPoints(points);
  vtkNew<vtkDoubleArray> field;
  field->SetName("f");
  for (const double value : values) field->InsertNextValue(value);
  curved->GetPointData()->AddArray(field);
  vtkNew<vtkXMLStructuredGridWriter> writer;
  writer->SetInputData(curved);
  writer->SetFileName((folder_ / "a.vts").c_str());
  ASSERT_EQ(writer->Write(), 1);
  const CellMesh expected = read_cells(folder_ / "a.vts", {});
  const std::string rest = geometry(item("4 3 2 3", in_words(places), "Precision=\"8\"")) +
                           attribute("f", item("4 3 2", in_words(values), "Precision=\"8\""));
  EXPECT_EQ(expected.kinds.size(), 6U);
  expect_same(read(xdmf(grid("a", "<Topology TopologyType=\"3DSMesh\" Dimensions=\"4 3 2\"/>\n" + rest))), expected);
  expect_same(read(xdmf(grid("a", "<Topology Type=\"3DSMesh\" NumberOfElements=\"4 3 2\"/>\n" + rest), "2.0")),
              expected);
}

TEST_F(Xdmf, is_a_mesh_or_a_volume_as_its_topology_says) {
  const auto kind = [&](const std::string& content, const char* name) {
    write_file(folder_ / name, content);
    return foreign_kind(folder_ / name);
  };
  const std::string lattice = "<Topology TopologyType=\"3DCORECTMesh\" Dimensions=\"2 2 2\"/>\n";
  EXPECT_EQ(kind(xdmf(grid("a", tet_cells + tet_points)), "a.xdmf"), ForeignKind::mesh);
  EXPECT_EQ(kind(xdmf(grid("a", lattice)), "b.xdmf"), ForeignKind::volume);
  EXPECT_EQ(kind(xdmf(grid("a", "<Topology Type=\"3DRectMesh\" Dimensions=\"2 2 2\"/>\n")), "c.XMF"),
            ForeignKind::volume);
  EXPECT_EQ(kind(xdmf(grid("a", "<Topology Reference=\"XML\">/Xdmf</Topology>" + lattice)), "d.xmf"),
            ForeignKind::volume);
  EXPECT_EQ(kind("no XML", "e.xmf"), ForeignKind::mesh);  // its reader says what is wrong
  EXPECT_EQ(kind("", "f.xmf"), ForeignKind::mesh);
}

/// The cache packs again when one of these files changes.
TEST_F(Xdmf, tells_the_files_that_were_read) {
  ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  write_pyramid(folder_ / "data.h5", H5T_IEEE_F64LE, H5T_STD_I32LE, {});
  write_file(folder_ / "more.bin", bytes_of_values(std::vector<float>{1, 2}));
  write_file(folder_ / "a.xdmf", pyramid(attribute("f", item("2", "more.bin", "Format=\"Binary\""), "Cell")));
  std::vector<std::string> names;
  for (const SourceFile& source : import_mesh(folder_ / "a.xdmf").sources) names.push_back(source.path.filename());
  EXPECT_THAT(names, UnorderedElementsAre("a.xdmf", "data.h5", "more.bin"));
}

}  // namespace
}  // namespace rhoray::preprocess
