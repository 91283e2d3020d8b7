#include <limits>
#include <map>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

const std::string format_2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string nodes_2 = "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n9 1 1 1.5\n7 2 2 2\n$EndNodes\n";
const std::string elements_2 =
    "$Elements\n5\n1 15 2 0 1 1\n2 2 2 5 6 1 2 3\n3 4 2 10 20 1 2 3 4\n4 4 3 11 21 99 2 3 4 9\n5 4 0 3 4 9 7\n"
    "$EndElements\n";
const std::string data_2 =
    "$NodeData\n1\n\"T of node\"\n1\n0.5\n3\n0\n1\n2\n1 7.5\n9 8.25\n$EndNodeData\n"
    "$NodeData\n1\n\"T of node\"\n1\n2\n3\n1\n1\n1\n1 -7.5\n$EndNodeData\n"
    "$ElementData\n1\n\"flow\"\n1\n2\n3\n1\n3\n2\n3 1 2 3\n5 4 5 6.1\n$EndElementData\n";
const std::string text_2 = format_2 + "$PhysicalNames\n2\n2 5 \"skin\"\n3 11 \"the core\"\n$EndPhysicalNames\n" +
                           nodes_2 + "$Comments\nanything $End goes\n$EndComments\n" + elements_2 + data_2;

/// The same mesh in version 4.1: two volumes, the first in groups 10 and 12.
const std::string text_4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$Entities\n1 0 0 2\n1 0 0 0 0\n20 0 0 0 1 1 1 2 10 12 0\n21 0 0 0 2 2 2 1 11 2 1 -2\n$EndEntities\n"
    "$Nodes\n2 6 1 9\n3 20 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 21 1 2\n9\n7\n1 1 1.5 0.25\n2 2 2 "
    "0.75\n$EndNodes\n"
    "$Elements\n4 5 1 5\n0 1 15 1\n1 1\n2 6 2 1\n2 1 2 3\n3 20 4 1\n3 1 2 3 4\n3 21 4 2\n4 2 3 4 9\n5 3 4 9 "
    "7\n$EndElements\n";

const NeutralField& field_of(const std::vector<NeutralField>& fields, const std::string& name) {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const NeutralField& field) { return field.name == name; });
  if (found == fields.end()) throw std::runtime_error("no field " + name);
  return *found;
}

bool is_complete(const CellMesh& mesh) {
  return mesh.points.size() == 6 && mesh.points[5] == std::array{2.0, 2.0, 2.0} &&
         mesh.cell_nodes == Array<std::uint64_t>{0, 1, 2, 3, 1, 2, 3, 4, 2, 3, 4, 5};
}

TEST(Gmsh, reads_version_2_with_groups) {
  TemporaryFolder folder;
  write_file(folder / "a.msh", text_2);
  const CellMesh mesh = read_cells(folder / "a.msh", {});
  EXPECT_TRUE(is_complete(mesh));
  EXPECT_THAT(mesh.kinds, testing::Each(CellKind::tetrahedron));
  EXPECT_THAT(mesh.cell_ids, testing::ElementsAre(2, 3, 4));
  EXPECT_THAT(field_of(mesh.cell_fields, "physical").values, testing::ElementsAre(10, 11, 0));
  EXPECT_THAT(field_of(mesh.cell_fields, "entity").values, testing::ElementsAre(20, 21, 0));
  EXPECT_EQ(field_of(mesh.cell_fields, "physical").label_names, (formats::LabelNames{{11, "the core"}}));
  EXPECT_TRUE(field_of(mesh.cell_fields, "entity").label_names.empty());
  EXPECT_THAT(mesh.notes,
              testing::UnorderedElementsAre(testing::HasSubstr("using the last of 2 time steps"),
                                            "1 triangle, 1 vertex left out: only cells that fill space are kept"));
}

TEST(Gmsh, reads_version_4_with_groups) {
  TemporaryFolder folder;
  write_file(folder / "a.msh", text_4);
  const CellMesh mesh = read_cells(folder / "a.msh", {});
  EXPECT_TRUE(is_complete(mesh));
  EXPECT_THAT(field_of(mesh.cell_fields, "physical").values, testing::ElementsAre(10, 11, 11));
  EXPECT_THAT(field_of(mesh.cell_fields, "entity").values, testing::ElementsAre(20, 21, 21));
  EXPECT_THAT(mesh.notes, testing::Contains(testing::HasSubstr("1 volume belongs to several physical groups")));
}

TEST(Gmsh, reads_fields_at_the_time_step_that_was_asked_for) {
  TemporaryFolder folder;
  for (const std::string& text : {text_2, text_4 + data_2}) {
    write_file(folder / "a.msh", text);
    const CellMesh last = read_cells(folder / "a.msh", {});
    EXPECT_EQ(field_of(last.point_fields, "T of node").values[0], -7.5);
    EXPECT_TRUE(std::isnan(field_of(last.point_fields, "T of node").values[4]));
    const CellMesh first = read_cells(folder / "a.msh", {.time = "first"});
    const NeutralField& t = field_of(first.point_fields, "T of node");
    EXPECT_EQ(t.values[0], 7.5);
    EXPECT_EQ(t.values[4], 8.25);
    EXPECT_TRUE(std::isnan(t.values[1]) && std::isnan(t.values[5]));
    EXPECT_TRUE(t.was_single_precision);
    const NeutralField& flow = field_of(first.cell_fields, "flow");  // the only one, whatever its time
    EXPECT_EQ(flow.component_count, 3);
    EXPECT_FALSE(flow.was_single_precision);
    ASSERT_EQ(flow.values.size(), 9U);
    EXPECT_EQ(flow.values[2], 3);
    EXPECT_TRUE(std::isnan(flow.values[3]));
    EXPECT_EQ(flow.values[8], 6.1);
  }
  write_file(folder / "a.msh", format_2 + nodes_2 + elements_2);
  expect_refusal([&] { read_cells(folder / "a.msh", {.time = "first"}); }, ErrorCode::usage, {"no time steps"});
}

template <class T>
std::string in_bytes(std::initializer_list<T> values, bool big_endian) {
  return bytes_of_values(std::vector<T>(values), big_endian);
}

TEST(Gmsh, reads_binary_numbers_in_both_byte_orders) {
  TemporaryFolder folder;
  for (const bool big : {false, true}) {
    const auto node = [&](std::int32_t id, double x, double y, double z) {
      return in_bytes({id}, big) + in_bytes({x, y, z}, big);
    };
    write_file(folder / "a.msh",
               "$MeshFormat\n2.2 1 8\n" + in_bytes<std::int32_t>({1}, big) + "\n$EndMeshFormat\n$Nodes\n6\n" +
                   node(1, 0, 0, 0) + node(2, 1, 0, 0) + node(3, 0, 1, 0) + node(4, 0, 0, 1) + node(9, 1, 1, 1.5) +
                   node(7, 2, 2, 2) + "\n$EndNodes\n$Elements\n3\n" +
                   in_bytes<std::int32_t>({4, 2, 2, 3, 10, 20, 1, 2, 3, 4, 4, 11, 21, 2, 3, 4, 9}, big) +
                   in_bytes<std::int32_t>({4, 1, 0, 5, 3, 4, 9, 7}, big) + "\n$EndElements\n");
    const CellMesh mesh = read_cells(folder / "a.msh", {});
    EXPECT_TRUE(is_complete(mesh));
    EXPECT_THAT(field_of(mesh.cell_fields, "physical").values, testing::ElementsAre(10, 11, 0));
  }
}

/// Elements that share a number, as in a file met in the wild: Gmsh itself keeps the last.
/// The mesh of version 4 cut into two partitions, as Gmsh writes it: elements name the entities of
/// the partitions, which repeat the physical groups.
TEST(Gmsh, reads_the_groups_of_partitions) {
  TemporaryFolder folder;
  const std::string head = "$MeshFormat\n4.1 ", text_head = head + "0 8\n$EndMeshFormat\n";
  write_file(folder / "a.msh",
             text_head +
                 "$PhysicalNames\n1\n3 7 \"liver\"\n$EndPhysicalNames\n"
                 "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 2 7 9 0\n$EndEntities\n"
                 "$PartitionedEntities\n2\n1\n5 2\n1 0 1 2\n4 0 1 2 1 2 0 0 0 0\n4 2 1 2 1 2 0 0 0 1 1 1 1 3 1 4\n"
                 "2 3 1 1 1 0 0 0 1 1 1 2 7 9 1 4\n3 3 1 1 2 0 0 0 1 1 1 1 7 0\n$EndPartitionedEntities\n"
                 "$Nodes\n1 5 1 5\n3 2 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n$EndNodes\n"
                 "$Elements\n2 2 1 2\n3 2 4 1\n1 1 2 3 4\n3 3 4 1\n2 2 3 4 5\n$EndElements\n");
  const CellMesh text = read_cells(folder / "a.msh", {});
  EXPECT_THAT(field_of(text.cell_fields, "physical").values, testing::ElementsAre(7, 7));
  EXPECT_THAT(field_of(text.cell_fields, "entity").values, testing::ElementsAre(2, 3));
  EXPECT_EQ(field_of(text.cell_fields, "physical").label_names, (formats::LabelNames{{7, "liver"}}));
  EXPECT_THAT(text.notes, testing::Contains("1 volume belongs to several physical groups; cell field 'physical' has "
                                            "the first"));
  const auto ints = [](std::initializer_list<std::int32_t> values) { return in_bytes<std::int32_t>(values, false); };
  const auto sizes = [](std::initializer_list<std::uint64_t> values) { return in_bytes<std::uint64_t>(values, false); };
  const auto reals = [](std::initializer_list<double> values) { return in_bytes<double>(values, false); };
  write_file(folder / "a.msh", head + "1 8\n" + ints({1}) + "\n$EndMeshFormat\n$PartitionedEntities\n" + sizes({2, 1}) +
                                   ints({5, 2}) + sizes({0, 0, 0, 1}) + ints({2, 3, 1}) + sizes({1}) + ints({1}) +
                                   reals({0, 0, 0, 1, 1, 1}) + sizes({1}) + ints({7}) + sizes({0}) +
                                   "\n$EndPartitionedEntities\n$Nodes\n" + sizes({1, 4, 1, 4}) + ints({3, 2, 0}) +
                                   sizes({4, 1, 2, 3, 4}) + reals({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) +
                                   "\n$EndNodes\n$Elements\n" + sizes({1, 1, 1, 1}) + ints({3, 2, 4}) +
                                   sizes({1, 1, 1, 2, 3, 4}) + "\n$EndElements\n");
  EXPECT_THAT(field_of(read_cells(folder / "a.msh", {}).cell_fields, "physical").values, testing::ElementsAre(7));
}

/// Gmsh's library gives every step the time 0 unless it is told another.
TEST(Gmsh, tells_steps_of_the_same_time_apart) {
  TemporaryFolder folder;
  const auto section = [](const std::string& name, const std::string& time, int step, int value) {
    return concat("$NodeData\n1\n\"", name, "\"\n1\n", time, "\n3\n", step, "\n1\n1\n1 ", value, "\n$EndNodeData\n");
  };
  const auto value = [&](const std::string& field, const std::string& time) {
    return field_of(read_cells(folder / "a.msh", {.time = time}).point_fields, field).values[0];
  };
  for (const char* time : {"0", "nan"}) {
    write_file(folder / "a.msh", format_2 + nodes_2 + elements_2 + section("u", time, 0, 1) +
                                     section("u", time, 1, 10) + section("v", time, 3, 5));
    EXPECT_EQ(value("u", {}), 10) << time;
    EXPECT_EQ(value("u", "first"), 1) << time;
    EXPECT_EQ(value("u", "#1"), 10) << time;
    EXPECT_EQ(value("v", {}), 5) << "the only one";
    EXPECT_THAT(read_cells(folder / "a.msh", {}).notes,
                testing::Contains(testing::HasSubstr("using the last of 2 time steps")));
  }
  // Fields that count their steps differently share the steps of their times.
  write_file(folder / "a.msh", format_2 + nodes_2 + elements_2 + section("u", "0", 0, 1) + section("u", "0.5", 1, 2) +
                                   section("u", "1", 2, 3) + section("v", "0", 0, 4) + section("v", "1", 1, 5));
  EXPECT_EQ(value("u", {}), 3);
  EXPECT_EQ(value("v", {}), 5);
  EXPECT_THAT(read_cells(folder / "a.msh", {}).notes,
              testing::Contains(testing::HasSubstr("the last of 3 time steps")));
}

/// Gmsh writes one section for each partition. Nodes between partitions may stand in several.
TEST(Gmsh, joins_the_values_of_partitions) {
  TemporaryFolder folder;
  const auto section = [](int step, int partition, const std::string& values) {
    return concat("$NodeData\n1\n\"u\"\n1\n", step, "\n4\n", step, "\n1\n3\n", partition, "\n", values,
                  "$EndNodeData\n");
  };
  const std::string both_steps = section(0, 1, "1 10\n2 20\n3 30\n") + section(1, 1, "1 11\n2 21\n3 31\n") +
                                 section(0, 2, "3 30\n4 40\n9 90\n") + section(1, 2, "3 31\n4 41\n9 91\n");
  write_file(folder / "a.msh", format_2 + nodes_2 + elements_2 + both_steps);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const int step : {0, 1}) {
    const CellMesh mesh = read_cells(folder / "a.msh", {.time = concat("#", step)});
    ASSERT_EQ(mesh.point_fields.size(), 1u);
    std::map<std::array<double, 3>, double> value_at;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) value_at[mesh.points[i]] = mesh.point_fields[0].values[i];
    EXPECT_THAT((std::vector{value_at[{0, 0, 0}], value_at[{0, 1, 0}], value_at[{0, 0, 1}]}),
                testing::ElementsAre(10 + step, 30 + step, 40 + step));
    EXPECT_THAT(value_at[(std::array{2.0, 2.0, 2.0})], testing::NanSensitiveDoubleEq(nan)) << "in no partition";
    EXPECT_THAT(mesh.notes, testing::Not(testing::Contains(testing::HasSubstr("field 'u'"))));
  }
  write_file(folder / "a.msh", format_2 + nodes_2 + elements_2 + both_steps + section(1, 3, "1 12\n2 21\n9 92\n"));
  const CellMesh mesh = read_cells(folder / "a.msh", {});
  EXPECT_EQ(mesh.point_fields[0].values[0], 11) << "the first value stays";
  EXPECT_THAT(mesh.notes, testing::Contains(testing::HasSubstr("field 'u': 2 values left out")));
}

TEST(Gmsh, keeps_elements_that_share_a_number) {
  TemporaryFolder folder;
  const std::string elements =
      "$Elements\n3\n44 4 2 0 1 1 2 3 4\n44 4 2 0 1 2 3 4 9\n44 4 2 0 1 3 4 9 7\n$EndElements\n";
  write_file(folder / "a.msh", format_2 + nodes_2 + elements);
  EXPECT_TRUE(is_complete(read_cells(folder / "a.msh", {})));
  write_file(folder / "a.msh", format_2 + nodes_2 + elements + data_2.substr(data_2.find("$ElementData")));
  expect_refusal([&] { read_cells(folder / "a.msh", {}); }, ErrorCode::invalid, {"'flow'", "two elements numbered 44"});
}

/// As Gmsh writes before each view that it appends.
TEST(Gmsh, passes_over_the_same_mesh_once_more_and_refuses_another) {
  TemporaryFolder folder;
  const std::string mesh = format_2 + nodes_2 + elements_2;
  write_file(folder / "a.msh", mesh + mesh + data_2);
  EXPECT_TRUE(is_complete(read_cells(folder / "a.msh", {})));
  std::string other = mesh;
  other.replace(other.find("1 1 1.5"), 7, "1 1 1.6");
  write_file(folder / "a.msh", mesh + other);
  expect_refusal([&] { read_cells(folder / "a.msh", {}); }, ErrorCode::unsupported,
                 {"line 24", "another section Nodes"});
}

TEST(Gmsh, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](std::string text, const std::string& from, const std::string& to, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    SCOPED_TRACE(to);
    text.replace(text.find(from), from.size(), to);
    write_file(folder / "a.msh", text);
    expect_refusal([&] { read_cells(folder / "a.msh", {}); }, error_code, words);
  };
  refuses(text_2, "2.2 0", "4 0", ErrorCode::unsupported, {"a.msh, line 2", "'4'", "4.1"});
  refuses(text_4, "4.1 0", "4.0 0", ErrorCode::unsupported, {"line 2", "'4.0'", "gmsh OLD.msh -save -format msh41"});
  refuses(text_2, "$MeshFormat", "$NOD", ErrorCode::unsupported, {"line 1", "MSH 1"});
  refuses(text_2, "2.2 0", "2.2 7", ErrorCode::invalid, {"line 2", "text or binary"});
  refuses(text_2, "0 8\n", "0 4\n", ErrorCode::unsupported, {"line 2"});
  refuses(text_2, "9 1 1 1.5", "4 1 1 1.5", ErrorCode::invalid, {"node 4 twice"});
  refuses(text_2, "2 3 4 9\n", "2 3 4 8\n", ErrorCode::invalid, {"element 4", "node 8"});
  refuses(text_2, "2 3 4 9\n", "2 3 4 -9\n", ErrorCode::invalid, {"element 4", "node -9"});
  refuses(text_2, "3 4 2 10 20", "3 29 2 10 20", ErrorCode::invalid, {"line 28", "an element's type"});
  refuses(text_2, "3 4 2 10 20", "3 32 2 10 20", ErrorCode::unsupported, {"line 25", "elements of type 32"});
  refuses(text_2, "3 4 2 10 20", "3 120 2 10 20", ErrorCode::unsupported, {"line 25", "elements of type 120"});
  refuses(text_2, "3 4 2 10 20", "3 4 -2 10 20", ErrorCode::invalid, {"line 25", "-2 tags"});
  refuses(text_2, "$Nodes\n6", "$Nodes\n7", ErrorCode::invalid, {"'$EndNodes'", "a node's number"});
  refuses(text_2, "$Nodes\n6", "$Nodes\n5", ErrorCode::invalid, {"'7'", "$EndNodes"});
  refuses(text_2, "$Nodes\n6", "$Nodes\n18446744073709551615", ErrorCode::invalid, {"a.msh"});
  refuses(text_2, "1 -7.5", "8 -7.5", ErrorCode::invalid, {"node 8", "one that is there"});
  refuses(text_4, "2 6 1 9", "2 7 1 9", ErrorCode::invalid, {"6 nodes", "7"});
  refuses(text_4, "4 5 1 5", "4 6 1 5", ErrorCode::invalid, {"5 elements", "6"});
  refuses(format_2 + nodes_2 + elements_2, elements_2, "$Elements\n1\n2 2 2 5 6 1 2 3\n$EndElements\n",
          ErrorCode::invalid, {"1 triangle", "fills space"});
  try {
    write_file(folder / "a.msh", format_2 + nodes_2 + "$Elements\n1\n2 2 2 5 6 1 2 3\n$EndElements\n");
    read_cells(folder / "a.msh", {});
  } catch (const Error& error) {
    EXPECT_THAT(error.hint(), testing::HasSubstr("rhoray tetrahedralize"));
  }
}

TEST(Gmsh, refuses_every_beginning_that_lacks_the_elements) {
  TemporaryFolder folder;
  for (const std::string& text : {text_2, text_4 + data_2})
    check_every_beginning(folder / "a.msh", text, [&] { return is_complete(read_cells(folder / "a.msh", {})); },
                          {.stride = 3, .is_text = true});
}

}  // namespace
}  // namespace rhoray::preprocess
