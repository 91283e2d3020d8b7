#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

const std::string whole =
    "MeshVersionFormatted 2\n# by hand\nDimension\n3\n\nVertices\n9\n0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n0 0 1 1\n1 0 "
    "1 "
    "1\n1 1 1 1\n0 1 1 1\n0.5 0.5 -1.5 2\n\nTriangles\n1\n1 2 3 7\nCorners\n2\n1\n2\n"
    "Tetrahedra 1\n1 2 4 5 20\nHexahedra\n1\n1 2 3 4 5 6 7 8 30\nPrisms\n1\n1 2 4 5 6 8 40\nPyramids\n1\n1 2 3 4 9 "
    "50\n\nEnd\n";

void expect_whole(const CellMesh& mesh) {
  ASSERT_EQ(mesh.points.size(), 9U);
  EXPECT_EQ(mesh.points[8], (std::array{0.5, 0.5, -1.5}));
  EXPECT_THAT(mesh.kinds,
              testing::ElementsAre(CellKind::tetrahedron, CellKind::hexahedron, CellKind::wedge, CellKind::pyramid));
  EXPECT_THAT(mesh.cell_nodes,
              testing::ElementsAre(0, 1, 3, 4, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 3, 4, 5, 7, 0, 1, 2, 3, 8));
  EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(20, 30, 40, 50));
  EXPECT_EQ(mesh.cell_fields[0].name, "reference");
  EXPECT_THAT(mesh.notes, testing::ElementsAre("1 triangle left out: only cells that fill space are kept"));
}

/// The binary form of the same, by the rules of libMeshb.
class BinaryMedit {
 public:
  BinaryMedit(std::int32_t version, bool big) : version_(version), big_(big) {
    put<std::int32_t>(1);
    put(version);
    section(3, [&] { put<std::int32_t>(3); });
  }
  template <class T>
  void put(T value) {
    bytes += bytes_of_values(std::vector<T>{value}, big_);
  }
  void integer(std::int64_t value) { version_ == 4 ? put(value) : put(static_cast<std::int32_t>(value)); }
  void real(double value) { version_ == 1 ? put(static_cast<float>(value)) : put(value); }
  void place(std::size_t value) {
    version_ >= 3 ? put(static_cast<std::int64_t>(value)) : put(static_cast<std::int32_t>(value));
  }
  void section(std::int32_t number, const std::function<void()>& content) {
    put(number);
    const std::size_t at = bytes.size();
    place(0);
    const std::size_t width = bytes.size() - at;
    content();
    const std::string after = bytes.substr(at + width);
    bytes.resize(at);
    place(at + width + after.size());
    bytes += after;
  }
  void end() {
    put<std::int32_t>(54);
    place(0);
  }
  void cells(std::int32_t number, const std::vector<std::int64_t>& nodes_and_reference) {
    section(number, [&] {
      integer(1);
      for (const std::int64_t value : nodes_and_reference) integer(value);
    });
  }
  std::string bytes;

 private:
  std::int32_t version_;
  bool big_;
};

std::string binary_mesh(std::int32_t version, bool big) {
  BinaryMedit file(version, big);
  file.section(4, [&] {
    file.integer(9);
    for (const std::array<double, 3>& point : std::vector<std::array<double, 3>>{{0, 0, 0},
                                                                                 {1, 0, 0},
                                                                                 {1, 1, 0},
                                                                                 {0, 1, 0},
                                                                                 {0, 0, 1},
                                                                                 {1, 0, 1},
                                                                                 {1, 1, 1},
                                                                                 {0, 1, 1},
                                                                                 {0.5, 0.5, -1.5}}) {
      for (const double coordinate : point) file.real(coordinate);
      file.integer(1);
    }
  });
  file.cells(6, {1, 2, 3, 7});
  file.cells(13, {1});  // a corner: not ours
  file.cells(8, {1, 2, 4, 5, 20});
  file.cells(10, {1, 2, 3, 4, 5, 6, 7, 8, 30});
  file.cells(9, {1, 2, 4, 5, 6, 8, 40});
  file.cells(49, {1, 2, 3, 4, 9, 50});
  file.end();
  return file.bytes;
}

TEST(Medit, reads_text) {
  TemporaryFolder folder;
  write_file(folder / "a.mesh", whole);
  expect_whole(read_cells(folder / "a.mesh", {}));
}

TEST(Medit, reads_every_binary_version_in_both_byte_orders) {
  TemporaryFolder folder;
  for (const std::int32_t version : {1, 2, 3, 4})
    for (const bool big : {false, true}) {
      SCOPED_TRACE(testing::Message() << "version " << version << (big ? ", big-endian" : ""));
      write_file(folder / "a.meshb", binary_mesh(version, big));
      expect_whole(read_cells(folder / "a.meshb", {}));
    }
}

TEST(Medit, reads_values_that_lie_beside) {
  TemporaryFolder folder;
  write_file(folder / "a.mesh", whole);
  std::string text = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n9\n3 1 2 3\n";
  for (int i = 0; i < 9; ++i) text += concat(i + 0.1, " ", i, " ", 2 * i, " ", 3 * i, " 1 2 3 4 5 6\n");
  write_file(folder / "a.sol", text + "End\n");
  CellMesh mesh = read_cells(folder / "a.mesh", {});
  ASSERT_EQ(mesh.point_fields.size(), 3U);
  EXPECT_EQ(mesh.point_fields[0].name, "solution_1");
  EXPECT_EQ(mesh.point_fields[0].values[8], 8.1);
  EXPECT_EQ(mesh.point_fields[1].component_count, 3);
  EXPECT_EQ(mesh.point_fields[1].values[26], 24);
  const Array<double>& tensors = mesh.point_fields[2].values;  // xx yx yy zx zy zz in the file
  EXPECT_THAT(std::vector(tensors.begin(), tensors.begin() + 6), testing::ElementsAre(1, 3, 6, 2, 5, 4));
  std::filesystem::remove(folder / "a.sol");

  BinaryMedit file(2, false);
  file.section(62, [&] {
    file.integer(9);
    file.put<std::int32_t>(1);
    file.put<std::int32_t>(1);
    for (int i = 0; i < 9; ++i) file.real(i / 3.0);
  });
  file.end();
  write_file(folder / "a.solb", file.bytes);
  mesh = read_cells(folder / "a.mesh", {});
  ASSERT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(mesh.point_fields[0].name, "solution");
  EXPECT_EQ(mesh.point_fields[0].values[8], 8 / 3.0);
  write_file(folder / "a.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n8\n1 1\nEnd\n");
  expect_refusal([&] { read_cells(folder / "a.mesh", {}); }, ErrorCode::invalid, {"a.sol, line 4", "8 vertices"});
}

TEST(Medit, notes_numbers_after_the_last_record_and_values_of_cells) {
  TemporaryFolder folder;
  const std::string points =
      "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n";
  write_file(folder / "a.mesh", points + "Corners\n2\n1 2\nTetrahedra\n1\n1 2 3 4 1\n2 3 4 5 2\nRidges\n1\n1\nEnd\n");
  write_file(folder / "a.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtTetrahedra\n1\n1 1\n5\nEnd\n");
  EXPECT_THAT(read_cells(folder / "a.mesh", {}).notes,
              testing::ElementsAre("a.mesh: section Tetrahedra: 5 numbers after its records were left out",
                                   "a.sol: section SolAtTetrahedra left out: only values at vertices are read"));
}

TEST(Medit, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& from, const std::string& to, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    SCOPED_TRACE(to);
    std::string text = whole;
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.mesh", text);
    expect_refusal([&] { read_cells(folder / "a.mesh", {}); }, error_code, words);
  };
  refuses("MeshVersionFormatted", "MeshVersion", ErrorCode::invalid, {"a.mesh, line 1", "'MeshVersion'"});
  refuses("Formatted 2", "Formatted 5", ErrorCode::unsupported, {"line 1", "1 to 4"});
  refuses("Dimension\n3", "Dimension\n2", ErrorCode::unsupported, {"line 4", "2 dimensions"});
  refuses("1 2 4 5 20", "1 2 4 10 20", ErrorCode::invalid, {"point 9", "0 to 8"});
  refuses("1 2 4 5 20", "1 2 4 0 20", ErrorCode::invalid, {"point -1"});
  refuses("1 2 4 5 20", "1 2 4 5", ErrorCode::invalid, {"'Hexahedra'"});
  refuses("Tetrahedra 1\n", "TetrahedraP3 1\n", ErrorCode::unsupported, {"section TetrahedraP3"});
  refuses("Tetrahedra 1\n", "TetrahedraP2 1\n", ErrorCode::unsupported, {"section TetrahedraP2"});
  refuses("Vertices\n9\n", "Vertices\n-9\n", ErrorCode::invalid, {"line 7", "-9"});
  refuses("Vertices\n9\n", "Vertices\n9000000000000000000\n", ErrorCode::invalid, {"a.mesh"});
}

TEST(Medit, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const auto is_complete = [](const CellMesh& mesh) {
    return mesh.points.size() == 9 && mesh.cell_nodes.size() == 23 && mesh.notes.size() == 1;
  };
  EXPECT_EQ(
      check_every_beginning(folder / "a.mesh", whole, [&] { return is_complete(read_cells(folder / "a.mesh", {})); }),
      1);  // the last line's end
  for (const std::int32_t version : {1, 4}) {
    const std::string bytes = binary_mesh(version, false);
    EXPECT_LE(check_every_beginning(folder / "a.meshb", bytes,
                                    [&] { return is_complete(read_cells(folder / "a.meshb", {})); }, {.stride = 11}),
              8);  // the place of the section behind the last
  }
}

/// Whatever four bytes say, the answer is an Error or a mesh that holds together.
TEST(Medit, survives_any_number_in_a_binary_file) {
  TemporaryFolder folder;
  const std::string content = binary_mesh(2, false);
  int refused = 0;
  for (std::size_t at = 0; at + 4 <= content.size(); at += 8)
    for (const std::string& number :
         {std::string("\xff\xff\xff\x7f", 4), std::string(4, '\xff'), std::string(4, '\0')}) {
      std::string changed = content;
      changed.replace(at, 4, number);
      write_file(folder / "b.meshb", changed);
      try {
        const CellMesh mesh = read_cells(folder / "b.meshb", {});
        for (const std::uint64_t node : mesh.cell_nodes) ASSERT_LT(node, mesh.points.size());
      } catch (const Error& error) {
        EXPECT_THAT(std::string(error.what()), testing::HasSubstr("b.meshb"));
        ++refused;
      }
    }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace rhoray::preprocess
