// XDMF files that lie: each is refused in one line that names the place.
#include <algorithm>
#include <numeric>

#include "preprocess/import/readers.h"
#include "preprocess/import_mesh.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/xdmf_files.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::HasSubstr;

class XdmfRefusals : public testing::Test {
 protected:
  void refuses(const std::string& content, ErrorCode code, const std::vector<std::string>& words) {
    write_file(folder_ / "a.xdmf", content);
    expect_refusal([&] { read_cells(folder_ / "a.xdmf", {}); }, code, words);
  }
  /// A grid with a tetrahedron whose one part is replaced.
  void refuses_grid(const std::string& parts, ErrorCode code, const std::vector<std::string>& words) {
    refuses(xdmf(grid("a", parts)), code, words);
  }
  void refuses_numbers(const std::string& numbers, ErrorCode code, const std::vector<std::string>& words) {
    refuses_grid(tet_cells + tet_points + attribute("f", numbers), code, words);
  }

  TemporaryFolder folder_;
};

struct Lie {
  std::string content;
  ErrorCode code;
  std::vector<std::string> words;
};

constexpr auto invalid = ErrorCode::invalid, unsupported = ErrorCode::unsupported;

TEST_F(XdmfRefusals, of_documents) {
  const std::string good = grid("a", tet_cells + tet_points);
  const std::string bomb =
      "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf [<!ENTITY a \"1111\"> <!ENTITY b "
      "\"&a;&a;\">]>\n<Xdmf><Domain>&b;</Domain></Xdmf>";
  std::string deep;
  for (int i = 0; i < 40; ++i) deep += "<Grid GridType=\"Tree\">";
  const Lie lies[] = {
      {"", invalid, {"a.xdmf, byte 0", "an empty file"}},
      {"no XML", invalid, {"a.xdmf, byte 6", "well-formed"}},
      {xdmf(good).substr(0, 300), invalid, {"well-formed"}},
      {bomb, unsupported, {"a.xdmf, document type: found entities", "not expanded"}},
      {"<!DOCTYPE Xdmf [ <!ELEMENT Xdmf ANY> ]>\n<Xdmf/>", invalid, {"well-formed"}},
      {xdmf(deep), invalid, {"well-formed"}},
      {"<VTKFile/>", invalid, {"root element: found 'VTKFile'; expected Xdmf"}},
      {xdmf(good, "4.0"), unsupported, {"line 3, Xdmf: found version '4.0'; expected 2.0 to 3.0"}},
      {"<Xdmf Version=\"2.1\"/>", invalid, {"found no Domain"}},
      {xdmf(""), invalid, {"Domain: found no Grid"}},
      {xdmf(collection("c", "Temporal", "")), invalid, {"no Grid; expected one for each time step"}},
      {xdmf(collection("c", "Spatial", "")), invalid, {"found no Grid"}},
      {xdmf(collection("c", "Hourly", good)), unsupported, {"type 'hourly'; expected Spatial or Temporal"}},
      {xdmf("<Grid GridType=\"SubSet\"/>"), unsupported, {"type 'subset'; expected Uniform"}},
      {xdmf(collection("c", "Spatial", collection("d", "Temporal", good))),
       unsupported,
       {"over time inside another Grid"}},
      {xdmf(collection("c", "Temporal", grid("a", "<Time Value=\"soon\"/>" + tet_cells + tet_points))),
       invalid,
       {"Time: found Value 'soon'; expected a number"}},
  };
  for (const Lie& lie : lies) refuses(lie.content, lie.code, lie.words);
}

TEST_F(XdmfRefusals, of_references) {
  const auto include = [](const std::string& attributes) { return concat("<xi:include ", attributes, "/>\n"); };
  const auto refer = [](const std::string& path) {
    return concat("<Topology Reference=\"XML\">", path, "</Topology>\n");
  };
  const Lie lies[] = {
      {include("href=\"/etc/passwd\" parse=\"text\""),
       unsupported,
       {"include: found the file '/etc/passwd'", "parts of the same file"}},
      {include("href=\"b.xdmf\" xpointer=\"xpointer(/Xdmf)\""), unsupported, {"the file 'b.xdmf'"}},
      {include(""), unsupported, {"found no xpointer"}},
      {include("xpointer=\"xpointer(id('x'))\""), unsupported, {"the path 'xpointer(id('x'))'"}},
      {include("xpointer=\"xpointer(/Xdmf/None)\""), invalid, {"found nothing at"}},
      {refer("../Topology"), unsupported, {"Topology: found the path '../Topology'"}},
      {refer("/Xdmf/Domain"), invalid, {"found no Topology at '/Xdmf/Domain'"}},
      {refer("/Xdmf/Domain/Grid/Topology"), invalid, {"references that lead in a circle"}},
  };
  for (const Lie& lie : lies) refuses_grid(lie.content + tet_points, lie.code, lie.words);
  const std::string good = grid("a", tet_cells + tet_points);
  refuses(xdmf(good + collection("c", "Spatial", include("xpointer=\"xpointer(//Grid)\""))), unsupported,
          {"a reference to a Grid"});
  refuses(xdmf(good + "<Grid Reference=\"XML\">/Xdmf/Domain/Grid[1]</Grid>"), unsupported, {"a reference to a Grid"});
}

/// References multiply what must be searched: the search ends.
TEST_F(XdmfRefusals, of_references_that_would_take_forever) {
  std::string grids;
  for (int i = 0; i < 1500; ++i)
    grids += concat("<Grid><Topology/><Geometry x=\"", i, "\"/><xi:include xpointer=\"xpointer(//*//*//Geometry[@x='",
                    i, "'])\"/></Grid>\n");
  refuses(xdmf(collection("c", "Spatial", grids)), unsupported, {"include: found the path"});
}

TEST_F(XdmfRefusals, of_files_outside_its_folder) {
  std::filesystem::create_directory(folder_ / "inside");
  write_file(folder_ / "secret.bin", bytes_of_values(std::vector<float>{1, 2, 3, 4}));
  write_file(folder_ / "inside/own.bin", bytes_of_values(std::vector<float>{5, 6, 7, 8}));
  const auto read = [&](const std::string& name) {
    write_file(folder_ / "inside/a.xdmf",
               xdmf(grid("a", tet_cells + tet_points + attribute("f", item("4", name, "Format=\"Binary\"")))));
    return read_cells(folder_ / "inside/a.xdmf", {}).point_fields.at(0).values[0];
  };
  EXPECT_EQ(read("own.bin"), 5);
  EXPECT_EQ(read("./own.bin"), 5);
  EXPECT_EQ(read((folder_ / "inside/own.bin").string()), 5);
  EXPECT_EQ(read("none/../own.bin"), 5);
  for (const std::string& name : {std::string("../secret.bin"), std::string("none/../../secret.bin"),
                                  (folder_ / "secret.bin").string(), std::string("/etc/hostname"), std::string("..")})
    expect_refusal([&] { read(name); }, unsupported, {"a.xdmf, line ", "DataItem: found the file", "or below it"});
  expect_refusal([&] { read("none.bin"); }, ErrorCode::unreadable, {"found no file 'none.bin'"});
  expect_refusal([&] { read("&#1;own.bin"); }, invalid, {"the file name"});
  expect_refusal([&] { read(""); }, invalid, {"the name of a file"});
  expect_refusal([&] { read("."); }, ErrorCode::unreadable, {"inside"});
}

TEST_F(XdmfRefusals, of_geometry_and_topology) {
  const auto tets = [](const std::string& numbers, const std::string& more = "") {
    return topology("Tetrahedron", numbers, more) + tet_points;
  };
  const std::string four = item("4", "0 1 2 3", "NumberType=\"Int\"");
  const auto mixed = [](const std::string& numbers, const std::string& more = "") {
    const auto count = 1 + std::count(numbers.begin(), numbers.end(), ' ');
    return topology("Mixed", item(concat(count), numbers, "NumberType=\"Int\""), more) + tet_points;
  };
  const Lie lies[] = {
      {tet_points, invalid, {"line 5, Grid: found no Topology"}},
      {tet_cells, invalid, {"found no Geometry"}},
      {topology("Tetrahedral", four) + tet_points, unsupported, {"cells of the type 'tetrahedral'"}},
      {topology("2DSMesh", four) + tet_points, unsupported, {"cells of the type '2dsmesh'"}},
      {topology("Hexahedron_64", four) + tet_points, unsupported, {"cells of the type 'hexahedron_64'"}},
      {tets(""), invalid, {"Topology: found 0 elements DataItem; expected 1"}},
      {tets(four + four), invalid, {"found 2 elements DataItem"}},
      {tets(four, "NumberOfElements=\"2\""), invalid, {"found 4 numbers; expected 2 cells of 4 nodes"}},
      {tets(four, "NumberOfElements=\"4611686018427387904\""),
       invalid,
       {"expected 4611686018427387904 cells of 4 nodes"}},
      {tets(four, "NumberOfElements=\"-1\""), invalid, {"NumberOfElements '-1'; expected sizes"}},
      {tets(four, "NodesPerElement=\"5\""), invalid, {"NodesPerElement '5'; expected 4"}},
      {topology("Polyline", four, "NodesPerElement=\"0\"") + tet_points, invalid, {"NodesPerElement '0'"}},
      {topology("Polyvertex", "", "NumberOfElements=\"1000000000000\"") + tet_points,
       invalid,
       {"found 1000000000000 points; expected 4"}},
      {tets(item("3", "0 1 2", "NumberType=\"Int\"")), invalid, {"found 3 numbers; expected 0 cells of 4 nodes"}},
      {tets(item("4", "0 1 2 3")), invalid, {"DataItem: found floating-point numbers; expected integers"}},
      {tets(item("4", "0 1 2 4", "NumberType=\"Int\"")), invalid, {"cell 0: found point 4; expected 0 to 3"}},
      {tets(item("4", "0 1 2 -1", "NumberType=\"Int\"")), invalid, {"cell 0: found point -1"}},
      {tets(four, "BaseOffset=\"1\""), invalid, {"cell 0: found point -1"}},
      {tets(four, "BaseOffset=\"one\""), invalid, {"BaseOffset 'one'; expected a number"}},
      {tets(four, "Order=\"1 0 2 3\""), unsupported, {"an Order of its own"}},
      {mixed("6 0 1 2"), invalid, {"found the end of the numbers in cell 0"}},
      {mixed("6 0 1 2 3 6"), invalid, {"the end of the numbers in cell 1"}},
      {mixed("6 0 1 2 3 9 9", "NumberOfElements=\"1\""), invalid, {"found 2 numbers behind the last cell"}},
      {mixed("6 0 1 2 3", "NumberOfElements=\"9\""), invalid, {"the end of the numbers in cell 1"}},
      {mixed("10 0 1 2 3"), unsupported, {"the kind 10 in cell 0"}},
      {mixed("3 -1 1 2 3"), invalid, {"found -1 nodes or faces in cell 0"}},
      {mixed("3 4000000 1 2 3"), invalid, {"found 4000000 nodes or faces"}},
      {mixed("16 4 3 0 1 2 3 0 1 3 3 1 2 3 3 2 0"), invalid, {"found 3 nodes or faces in cell 0"}},
      {mixed("16 4 3 0 1 2 3 0 1 3 3 1 2 3 3 2 0 7"), invalid, {"cell 0: found point 7"}},
      {tet_cells + geometry(item("4 4", "0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0")),
       invalid,
       {"found 16 coordinates; expected 3 for each point"}},
      {tet_cells + geometry(item("4 3", "0 0 0 1 0 0 0 1 0 0 0 1"), "XYZW"),
       unsupported,
       {"points of the type 'xyzw'"}},
      {tet_cells + geometry(item("4", "0 0 0 0"), "X_Y_Z"), invalid, {"found 1 elements DataItem; expected 3"}},
      {tet_cells + geometry(item("4", "0 0 0 0") + item("3", "0 0 0") + item("4", "0 0 0 0"), "X_Y_Z"),
       invalid,
       {"found 3 coordinates; expected 4"}},
      {"<Topology TopologyType=\"3DSMesh\" Dimensions=\"2 2 3\"/>\n" + tet_points,
       invalid,
       {"found 4 points; expected 3 x 2 x 2 points"}},
      {"<Topology TopologyType=\"3DSMesh\" Dimensions=\"1 2 2\"/>\n" + tet_points,
       unsupported,
       {"at least 2 along each axis"}},
      {"<Topology TopologyType=\"3DRectMesh\" Dimensions=\"2 2 2\"/>\n" + tet_points,
       unsupported,
       {"cells of the type '3drectmesh'"}},
  };
  for (const Lie& lie : lies) refuses_grid(lie.content, lie.code, lie.words);
}

TEST_F(XdmfRefusals, of_data_items) {
  write_file(folder_ / "a.bin", std::string(16, '\0'));
  const std::string whole = item("2 4", "0 0 0 0 0 0 0 0");
  const auto slab = [&](const std::string& part, const std::string& sizes = "4", const std::string& source = {}) {
    const auto count = part.empty() ? 0 : 1 + std::count(part.begin(), part.end(), ' ');
    return concat("<DataItem ItemType=\"HyperSlab\" Dimensions=\"", sizes, "\">",
                  item(concat(count), part, "NumberType=\"Int\""), source.empty() ? whole : source, "</DataItem>\n");
  };
  const auto binary = [](const std::string& sizes, const std::string& more) {
    return item(sizes, "a.bin", concat("Format=\"Binary\" ", more));
  };
  const Lie lies[] = {
      {"<DataItem>1 2 3 4</DataItem>", invalid, {"DataItem: found no Dimensions"}},
      {item("4", "1  2  3"), invalid, {"found 3 numbers; expected 4"}},
      {item("4", "1 2 3 4 5"), invalid, {"found more than 4 numbers"}},
      {item("4000000000", "1 2 3 4"), invalid, {"found 7 bytes of text; expected 4000000000 numbers"}},
      {item("4 18446744073709551615", "1"), invalid, {"whose product fits in memory"}},
      {item("4 x", "1"), invalid, {"Dimensions '4 x'; expected sizes"}},
      {item(" ", "1"), invalid, {"sizes whose product"}},
      {item("8", "1 2 3 4 5 6 7 8"), invalid, {"found 2 numbers for each point; expected 1, as a scalar has"}},
      {item("2", "1 2"), invalid, {"found 2 numbers of attribute 'f'", "for each of 4 points"}},
      {item("4", "1 two 3 4"), invalid, {"line 13, DataItem: found 'two'; expected a number of its type"}},
      {item("4", "1 2 3 999", "NumberType=\"UChar\""), invalid, {"found '999'"}},
      {item("4", "1 2 3 4", "NumberType=\"String\""), unsupported, {"numbers 'string' of '' bytes"}},
      {item("4", "1 2 3 4", "Precision=\"3\""), unsupported, {"numbers 'float' of '3' bytes"}},
      {item("4", "1 2 3 4", "Format=\"TIFF\""), unsupported, {"the format 'tiff'; expected XML, HDF or Binary"}},
      {item("4", "1 2 3 4", "ItemType=\"Coordinates\""),
       unsupported,
       {"the kind 'coordinates'; expected Uniform or HyperSlab"}},
      {binary("5", ""), invalid, {"found 16 bytes in 'a.bin'; expected 5 numbers"}},
      {binary("4", "Seek=\"1\""), invalid, {"expected 4 numbers behind the first 1 bytes"}},
      {binary("4", "Seek=\"18446744073709551615\""), invalid, {"found 16 bytes"}},
      {binary("4", "Seek=\"-1\""), invalid, {"Seek '-1'"}},
      {binary("4611686018427387904", "Precision=\"8\""), invalid, {"found 16 bytes"}},
      {binary("4", "Endian=\"Middle\""), invalid, {"the byte order 'middle'"}},
      {binary("4", "Compression=\"Zlib\""), unsupported, {"the compression 'zlib'"}},
      {slab("1 1 1 1 1 4"), invalid, {"found 4 from 1 on, 1 apart, along axis 1; expected some of 4"}},
      {slab("0 0 1 2 1 3"), invalid, {"found 3 from 0 on, 2 apart"}},
      {slab("2 0 1 1 1 4"), invalid, {"along axis 0"}},
      {slab("0 0 0 1 1 4"), invalid, {"0 apart"}},
      {slab("0 0 1 1 0 4"), invalid, {"found 0 from 0"}},
      {slab("0 0 1 9223372036854775807 1 9223372036854775807"), invalid, {"along axis 1"}},
      {slab("0 0 1 -1 1 4"), invalid, {"found -1; expected numbers from 0 on"}},
      {slab("0 1 4"), invalid, {"found 2 sizes in Dimensions; expected 1"}},
      {slab("0 0 1 1 4"), invalid, {"found 5 numbers; expected a start, a stride and a count"}},
      {slab(""), invalid, {"found 0 numbers"}},
      {slab("0 0 1 1 1 4", "5"), invalid, {"found 5 numbers in Dimensions; expected 4, as the HyperSlab selects"}},
      {"<DataItem ItemType=\"HyperSlab\" Dimensions=\"4\">" + whole + "</DataItem>",
       invalid,
       {"found 1 elements DataItem; expected 2"}},
  };
  for (const Lie& lie : lies) refuses_numbers(lie.content, lie.code, lie.words);
  const std::string good = slab("0 0 1 1 1 4");
  write_file(folder_ / "a.xdmf", xdmf(grid("a", tet_cells + tet_points + attribute("f", good))));
  EXPECT_EQ(read_cells(folder_ / "a.xdmf", {}).point_fields.size(), 1U);
}

std::string heavy(const std::string& sizes, const std::string& name, const std::string& more = "") {
  return item(sizes, concat("a.h5:", name), concat("Format=\"HDF\" ", more));
}

TEST_F(XdmfRefusals, of_hdf5) {
  {
    const Hdf5Writer file(folder_ / "a.h5");
    file.array("four", H5T_IEEE_F64LE, {4}, {1, 2, 3, 4});
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Dclose(file.make("text", text, {4}, H5P_DEFAULT));
    H5Tclose(text);
    H5Dclose(file.make("wide", H5T_NATIVE_LDOUBLE, {4}, H5P_DEFAULT));
    H5Dclose(file.make("unwritten", H5T_IEEE_F64LE, {4}, H5P_DEFAULT));
    const hid_t sparse = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk = 4;
    H5Pset_chunk(sparse, 1, &chunk);
    const hsize_t huge = hsize_t{1} << 40, first = 0, count = 4;
    const hid_t set = file.make("sparse", H5T_IEEE_F64LE, {huge}, sparse);
    const hid_t space = H5Dget_space(set), memory = H5Screate_simple(1, &count, nullptr);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &count, nullptr);
    const double four[] = {1, 2, 3, 4};
    EXPECT_GE(H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, four), 0);
    H5Sclose(space);
    H5Sclose(memory);
    H5Dclose(set);
    H5Pset_deflate(sparse, 9);
    file.part("half", {8}, sparse);
    const double fill = 7;
    H5Pset_fill_value(sparse, H5T_NATIVE_DOUBLE, &fill);
    file.part("filled", {8}, sparse);
    H5Pclose(sparse);
  }
  const Lie lies[] = {
      {heavy("4", "none"), invalid, {"a.h5, data set 'none': found none"}},
      {heavy("4", "four/five"), invalid, {"data set 'four/five'"}},
      {heavy("4", "/"), invalid, {"data set '/'"}},
      {heavy("5", "four"),
       invalid,
       {"a.xdmf, line 13, DataItem: found 5 numbers in Dimensions; expected 4, as 'four' has"}},
      {heavy("4", "text"), unsupported, {"data set 'text': found other data"}},
      {heavy("4", "wide"), unsupported, {"data set 'wide': found other data"}},
      {heavy("4", "unwritten"), invalid, {"data set 'unwritten'", "never written"}},
      {heavy("1099511627776", "sparse"), invalid, {"found 32 bytes; expected 8796093022208"}},
      {heavy("4", "four|0:1:4:5"), invalid, {"a part of an array of other sizes"}},
      {heavy("4", "four|1:1:4:4"), invalid, {"found 4 from 1 on"}},
      {heavy("4", "four|0:1:4"), invalid, {"START:STRIDE:COUNT:SHAPE"}},
      {heavy("4", "four|0:1:4:x"), invalid, {"found 'x'; expected a number"}},
      {item("4", "a.h5", "Format=\"HDF\""), invalid, {"found 'a.h5'; expected a file and a data set"}},
      {item("4", "a.h5:", "Format=\"HDF\""), invalid, {"the name of a data set behind the colon"}},
      {item("4", "b.h5:/four", "Format=\"HDF\""), ErrorCode::unreadable, {"found no file 'b.h5'"}},
      {item("4", "../a.h5:/four", "Format=\"HDF\""), unsupported, {"the file '../a.h5'"}},
      {concat("<DataItem ItemType=\"HyperSlab\">", item("3", "0 1 4", "NumberType=\"Int\""), heavy("5", "four"),
              "</DataItem>"),
       invalid,
       {"found 5 numbers in Dimensions"}},
      {concat("<DataItem ItemType=\"HyperSlab\">", item("3", "0 1 4", "NumberType=\"Int\""), heavy("4", "four|0:1:4:4"),
              "</DataItem>"),
       unsupported,
       {"found a part of a part"}},
  };
  for (const Lie& lie : lies) refuses_numbers(lie.content, lie.code, lie.words);
  // a part of the same sparse array is read
  write_file(folder_ / "a.xdmf",
             xdmf(grid("a", tet_cells + tet_points +
                                attribute("f", concat("<DataItem ItemType=\"HyperSlab\">",
                                                      item("3", "0 1 4", "NumberType=\"Int\""),
                                                      heavy("1099511627776", "sparse"), "</DataItem>")))));
  EXPECT_THAT(read_cells(folder_ / "a.xdmf", {}).point_fields.at(0).values, testing::ElementsAre(1, 2, 3, 4));
  // so is the written part of an array that lacks others, and one with a value for these
  for (const auto& [text, last] :
       {std::pair(heavy("4", "half|0:1:4:8"), 4.0), std::pair(heavy("4", "filled|4:1:4:8"), 7.0)}) {
    write_file(folder_ / "a.xdmf", xdmf(grid("a", tet_cells + tet_points + attribute("f", text))));
    EXPECT_EQ(read_cells(folder_ / "a.xdmf", {}).point_fields.at(0).values.at(3), last) << text;
  }
  refuses_numbers(heavy("4", "half|1:2:4:8"), invalid, {"data set 'half': found a part without numbers"});
  write_file(folder_ / "a.h5", "no HDF5");
  refuses_numbers(heavy("4", "four"), invalid, {"a.h5, header: found damaged data, or another format"});
  write_file(folder_ / "a.h5", "");
  refuses_numbers(heavy("4", "four"), invalid, {"a.h5, byte 0: found an empty file"});
}

/// HDF5 follows links to other files, and reads numbers and parts of arrays from them.
TEST_F(XdmfRefusals, of_hdf5_that_leads_to_other_files) {
  { Hdf5Writer(folder_ / "secret.h5").array("four", H5T_IEEE_F64LE, {4}, {1, 2, 3, 4}); }
  write_file(folder_ / "secret.bin", bytes_of_values(std::vector<double>{1, 2, 3, 4}));
  {
    const Hdf5Writer file(folder_ / "a.h5");
    EXPECT_GE(H5Lcreate_external((folder_ / "secret.h5").c_str(), "/four", file.id(), "link", H5P_DEFAULT, H5P_DEFAULT),
              0);
    EXPECT_GE(H5Lcreate_external((folder_ / "secret.h5").c_str(), "/", file.id(), "folder", H5P_DEFAULT, H5P_DEFAULT),
              0);
    EXPECT_GE(H5Lcreate_soft("/folder/four", file.id(), "soft", H5P_DEFAULT, H5P_DEFAULT), 0);
    EXPECT_GE(H5Lcreate_soft("/circle", file.id(), "circle", H5P_DEFAULT, H5P_DEFAULT), 0);
    const hid_t external = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(external, (folder_ / "secret.bin").c_str(), 0, 32);
    H5Dclose(file.make("external", H5T_IEEE_F64LE, {4}, external));
    H5Pclose(external);
    const hid_t mapped = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t four = 4;
    const hid_t space = H5Screate_simple(1, &four, nullptr);
    EXPECT_GE(H5Pset_virtual(mapped, space, (folder_ / "secret.h5").c_str(), "/four", space), 0);
    H5Dclose(file.make("virtual", H5T_IEEE_F64LE, {4}, mapped));
    H5Sclose(space);
    H5Pclose(mapped);
  }
  for (const char* name : {"link", "folder/four", "soft", "circle"})
    refuses_numbers(heavy("4", name), invalid, {"found none, or a link out of the file"});
  for (const char* name : {"external", "virtual"})
    refuses_numbers(heavy("4", name), unsupported, {"found numbers in other files"});
}

/// HDF5 itself may end the process on some of them: through the worker, that is a sentence, too.
TEST_F(XdmfRefusals, of_every_beginning) {
  ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  { Hdf5Writer(folder_ / "a.h5").array("four", H5T_IEEE_F64LE, {4}, {1, 2, 3, 4}, {4}); }
  const std::string content = xdmf(grid("a", tet_cells + tet_points + attribute("f", heavy("4", "four"))));
  const auto is_whole = [&] { return import_mesh(folder_ / "a.xdmf").point_fields.at(0).values[3] == 4; };
  write_file(folder_ / "a.xdmf", content);
  ASSERT_TRUE(is_whole());
  EXPECT_LE(check_every_beginning(folder_ / "a.xdmf", content, is_whole, {.stride = 61}), 2);
  const std::string data = read_file(folder_ / "a.h5");
  EXPECT_EQ(check_every_beginning(folder_ / "a.h5", data, is_whole, {.stride = 197}), 0);
}

}  // namespace
}  // namespace rhoray::preprocess
