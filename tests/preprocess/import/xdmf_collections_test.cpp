// Collections in XDMF files: time steps, parts in space, and references from one Grid to another.
#include "preprocess/import/readers.h"
#include "preprocess/import/xdmf/element_path.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/xdmf_files.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class XdmfCollections : public XdmfMeshes {};

std::string time_of(const std::string& value) {
  return concat("<Time Value=\"", value, "\"/>\n");
}

/// A field of one value at all four points.
std::string field(const std::string& name, const std::string& value) {
  return attribute(name, item("4 1", concat(value, " ", value, " ", value, " ", value)));
}

std::string include(const std::string& path) {
  return concat("<xi:include xpointer=\"xpointer(", path, ")\"/>\n");
}

std::string step(const std::string& mesh, const std::string& time, const std::string& value) {
  return grid("step", mesh + time_of(time) + field("u", value));
}

TEST_F(XdmfCollections, have_time_steps) {
  const std::string mesh = tet_cells + tet_points;
  const std::string content = xdmf(
      collection("series", "Temporal", step(mesh, "0", "10") + step(mesh, " 0.5 ", "20") + step(mesh, "2.0e0", "30")));
  const auto value = [&](const std::string& time) { return read(content, time).point_fields.at(0).values[0]; };
  EXPECT_EQ(value(""), 30);
  EXPECT_THAT(read(content).notes, ElementsAre("using the last of 3 time steps (t = 2); choose another with --time"));
  EXPECT_EQ(value("first"), 10);
  EXPECT_EQ(value("#1"), 20);
  EXPECT_EQ(value("0.5"), 20);
  EXPECT_EQ(value("1.9"), 30);
  EXPECT_THAT(read(content, "2").notes, IsEmpty());
  expect_refusal([&] { read(content, "#3"); }, ErrorCode::usage, {"a.xdmf, time step: found '#3'", "#0 to #2"});
  expect_refusal([&] { read(xdmf(grid("a", mesh)), "last"); }, ErrorCode::usage, {"found no time steps"});
}

TEST_F(XdmfCollections, may_list_their_times_together) {
  const std::string mesh = tet_cells + tet_points;
  const auto value = [&](const std::string& times) {
    const std::string steps =
        grid("a", mesh + field("u", "10")) + grid("b", mesh + field("u", "20")) + grid("c", mesh + field("u", "30"));
    return read(xdmf(collection("series", "Temporal", times + steps)), "7").point_fields.at(0).values[0];
  };
  EXPECT_EQ(value("<Time TimeType=\"List\">" + item("3", "6.9 7.2 100") + "</Time>\n"), 10);
  EXPECT_EQ(value("<Time TimeType=\"HyperSlab\">" + item("3", "4 3 3") + "</Time>\n"), 20);
  expect_refusal([&] { value("<Time TimeType=\"List\">" + item("2", "1 2") + "</Time>\n"); }, ErrorCode::invalid,
                 {"DataItem: found 2 numbers; expected 3"});
}

/// As FEniCS writes it: the first step has the mesh, the others refer to it.
TEST_F(XdmfCollections, refer_to_the_mesh_of_their_first_step_as_in_files_of_fenics) {
  const std::string mesh =
      include("//Grid[@Name=&quot;TimeSeries_u&quot;]/Grid[1]/*[self::Topology or self::Geometry]");
  const std::string content =
      xdmf(collection("TimeSeries_u", "Temporal",
                      grid("mesh", tet_cells + tet_points + time_of("0") + field("u", "10")) +
                          concat("<Grid>\n", mesh, time_of("1"), field("u", "20"), "</Grid>\n")));
  const CellMesh last = read(content);
  EXPECT_EQ(last.kinds.size(), 1U);
  EXPECT_EQ(last.point_fields.at(0).values[0], 20);
  EXPECT_EQ(read(content, "first").point_fields.at(0).values[0], 10);
}

/// As dolfinx writes it: a mesh, tags of its faces, and a collection for each function.
TEST_F(XdmfCollections, refer_to_a_mesh_beside_them_as_in_files_of_dolfinx) {
  const std::string mesh = include("/Xdmf/Domain/Grid[@GridType='Uniform'][1]/*[self::Topology or self::Geometry]");
  const std::string tags =
      grid("facet_tags", include("/Xdmf/Domain/Grid/Geometry") +
                             topology("Triangle", item("2 3", "0 1 2 1 2 3", "NumberType=\"Int\"")) +
                             attribute("facet_tags", item("2 1", "7 8"), "Cell"));
  const CellMesh both = read(xdmf(grid("mesh", tet_cells + tet_points) + tags +
                                  collection("u", "Temporal", step(mesh, "0", "10") + step(mesh, "1", "20")) +
                                  collection("p", "Temporal",
                                             grid("p", mesh + time_of("0") + field("p", "1")) +
                                                 grid("p", mesh + time_of("1") + field("p", "2"))) +
                                  collection("q", "Temporal",
                                             grid("q", mesh + time_of("5") + field("q", "1")) +
                                                 grid("q", mesh + time_of("6") + field("q", "2")))),
                             "first");
  ASSERT_EQ(both.point_fields.size(), 2U);
  EXPECT_EQ(both.point_fields[0].values[0], 10);
  EXPECT_EQ(both.point_fields[1].name, "p");
  EXPECT_EQ(both.point_fields[1].values[0], 1);
  EXPECT_THAT(both.cell_fields, IsEmpty());
  EXPECT_THAT(both.notes, ElementsAre("grid 'facet_tags' left out: it has another mesh than grid 'u'",
                                      "grid 'q' left out: it has another time than grid 'u'"));
}

TEST_F(XdmfCollections, refer_to_elements_in_other_ways) {
  const std::string mesh = grid("mesh", tet_cells + tet_points + field("u", "4"));
  const auto value = [&](const std::string& parts) {
    // the collection over time comes first, whatever the order
    return read(xdmf(mesh + collection("c", "Temporal", "<Grid>\n" + parts + field("v", "5") + "</Grid>\n")))
        .cell_nodes;
  };
  const auto nodes = ElementsAre(0, 1, 2, 3);
  EXPECT_THAT(value("<Topology Reference=\"XML\">/Xdmf/Domain/Grid[@Name=\"mesh\"]/Topology</Topology>\n"
                    "<Geometry Reference=\"/Xdmf/Domain/Grid[1]/Geometry\"/>\n"),
              nodes);
  EXPECT_THAT(value("<xi:include xpointer=\"element(/1/1/1/1)\"/>\n<xi:include xpointer=\"element(/1/1/1/2)\"/>\n"),
              nodes);
  EXPECT_THAT(value("<ns0:include xpointer=\"xpointer(//Grid[@Name=&quot;mesh&quot;]/*)\"/>\n"), nodes);
  EXPECT_THAT(
      value(topology("Tetrahedron", "<DataItem Reference=\"XML\"> /Xdmf/Domain/Grid/Topology/DataItem\n</DataItem>") +
            tet_points),
      nodes);
  // attributes come along with the mesh of the same name
  EXPECT_THAT(value("<include xpointer=\"xpointer(/Xdmf/Domain/Grid/*)\"/>\n"), nodes);
}

TEST_F(XdmfCollections, in_space_are_joined_at_common_points) {
  const std::string second = geometry(item("4 3", "1 0 0 0 1 0 0 0 1 1 1 1"));
  const auto parts = [&](const std::string& fields) {
    return grid("a", tet_cells + tet_points + field("u", "1") + field("w", "1")) +
           grid("b", tet_cells + second + fields);
  };
  const std::string tree = concat("<Grid Name=\"all\" GridType=\"Tree\">\n", parts(field("u", "2")), "</Grid>\n");
  for (const std::string& content :
       {collection("all", "Spatial", parts(field("u", "2"))), tree,
        concat("<Grid GridType=\"Collection\">\n", tree, "</Grid>\n"),
        collection("times", "Temporal", collection("all", "Spatial", time_of("3") + parts(field("u", "2"))))}) {
    const CellMesh mesh = read(xdmf(content));
    EXPECT_EQ(mesh.points.size(), 5U);
    EXPECT_THAT(mesh.cell_nodes, ElementsAre(0, 1, 2, 3, 1, 2, 3, 4));
    ASSERT_EQ(mesh.point_fields.size(), 1U);
    EXPECT_THAT(mesh.point_fields[0].values, ElementsAre(1, 1, 1, 1, 2));
    EXPECT_THAT(mesh.notes, Contains("field 'w' at points left out: not every piece has it"));
  }
}

TEST_F(XdmfCollections, on_the_same_mesh_by_its_text_add_their_attributes) {
  const CellMesh mesh = read(
      xdmf(grid("a", tet_cells + tet_points + field("u", "1")) + grid("b", tet_cells + tet_points + field("v", "2")) +
           grid("c", tet_cells + geometry(item("4 3", "0 0 0 1 0 0 0 1 0 0 0 2")) + field("w", "3"))));
  ASSERT_EQ(mesh.point_fields.size(), 2U);
  EXPECT_EQ(mesh.point_fields[1].name, "v");
  EXPECT_THAT(mesh.notes, ElementsAre("grid 'c' left out: it has another mesh than grid 'a'"));
}

TEST_F(XdmfCollections, come_from_the_first_domain) {
  std::string content = xdmf(grid("a", tet_cells + tet_points));
  content.insert(content.find("</Xdmf>"), "<Domain>nothing</Domain>\n");
  EXPECT_THAT(read(content).notes, ElementsAre("only the first of several Domains was read"));
}

TEST(ElementPath, selects_by_names_positions_and_attributes) {
  const std::string text =
      "<R><G n=\"a]\"><T i=\"0\"/><P i=\"1\"/></G><G n='b'><T i=\"2\"/><G><T i=\"3\"/><T i=\"4\"/></G></G></R>";
  std::size_t end = 0;
  const std::optional<XmlElement> root = xml_outline(text, "", end);
  ASSERT_TRUE(root);
  const auto select = [&](std::string_view path, std::uint64_t visits = 1000) -> std::string {
    const auto found = select_elements(*root, path, visits);
    if (!found) return "not understood";
    std::string all;
    for (const XmlElement* element : *found) all += concat(all.empty() ? "" : " ", element->attribute("i"));
    return all;
  };
  EXPECT_EQ(select("/R/G/T"), "0 2");
  EXPECT_EQ(select("//T"), "0 2 3 4");
  EXPECT_EQ(select("/R//T[2]"), "4");
  EXPECT_EQ(select("/R/G[2]/G/T[1]"), "3");
  EXPECT_EQ(select("//G[@n='b']/T"), "2");
  EXPECT_EQ(select(" xpointer( //G[@n = \"a]\"]/*[self::P or self::T] ) "), "0 1");
  EXPECT_EQ(select("//G[@n=\"b\"][1]/*[self::T]"), "2");
  EXPECT_EQ(select("element(/1/2/2/2)"), "4");
  EXPECT_EQ(select("element(/1/9)"), "");
  EXPECT_EQ(select("/X/G"), "");
  for (const char* path :
       {"", "/", "R/G", "/R/", "/R[", "/R[x]", "/R[@n]", "/R[@n=b]", "/R[]", "//R[self:]", "element(1)",
        "element(/0x1)", "element()", "xpointer()", "/R/G[@n=\"b\"", "../G", "/R/G/T/@i"})
    EXPECT_EQ(select(path), "not understood") << path;
  EXPECT_EQ(select("//T", 8), "not understood");
  EXPECT_EQ(select("//T", 9), "0 2 3 4");
}

}  // namespace
}  // namespace rhoray::preprocess
