// Files written by Gmsh's own library, read by our reader.

#include <gmsh.h>
#include <vtkLagrangeHexahedron.h>
#include <vtkLagrangeTetra.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include "preprocess/import/mesh/gmsh_elements.h"
#include "preprocess/import/readers.h"
#include "tests/preprocess/import/node_places.h"
#include "tests/preprocess/import/support.h"

#ifdef __SANITIZE_ADDRESS__
// Gmsh's library frees with free() what it got by new.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "alloc_dealloc_mismatch=0";
}
#endif

namespace rhoray::preprocess {
namespace {

using namespace tests;

class GmshLibrary : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    gmsh::initialize();
    gmsh::option::setNumber("General.Terminal", 0);
  }
  static void TearDownTestSuite() { gmsh::finalize(); }
  void SetUp() override { gmsh::clear(); }

  struct Properties {
    std::string name;
    int dimension = 0, order = 0, node_count = 0;
    std::vector<double> places;  ///< of the nodes in the reference cell
  };
  static Properties properties(int type) {
    Properties result;
    int corner_count = 0;
    gmsh::model::mesh::getElementProperties(type, result.name, result.dimension, result.order, result.node_count,
                                            result.places, corner_count);
    return result;
  }

  /// A model of one element in the volume 7, whose nodes stand in their places of the reference
  /// cell.
  static void make_model(int type, const Properties& of) {
    gmsh::clear();
    gmsh::model::addDiscreteEntity(3, 7);
    std::vector<std::size_t> tags;
    for (int i = 0; i < of.node_count; ++i) tags.push_back(static_cast<std::size_t>(10 + 3 * i));  // with gaps
    gmsh::model::mesh::addNodes(3, 7, tags, of.places);
    gmsh::model::mesh::addElementsByType(7, type, {5}, tags);
    gmsh::model::addPhysicalGroup(3, {7}, 42);
    gmsh::model::setPhysicalName(3, 42, "core");
  }

  /// Every version and both forms, one after another.
  void in_every_form(const std::function<void(const std::filesystem::path&)>& act) {
    for (const double version : {2.2, 4.1})
      for (const int binary : {0, 1}) {
        SCOPED_TRACE(testing::Message() << "version " << version << (binary ? ", binary" : ", text"));
        gmsh::option::setNumber("Mesh.MshFileVersion", version);
        gmsh::option::setNumber("Mesh.Binary", binary);
        act(folder_ / "a.msh");
      }
  }
  TemporaryFolder folder_;
};

TEST_F(GmshLibrary, numbers_its_element_types_as_our_table_does) {
  int known = 0;
  for (int type = 1; type <= 140; ++type) {
    Properties of;
    try {
      of = properties(type);
    } catch (...) {
      EXPECT_FALSE(gmsh_element(static_cast<std::uint64_t>(type))) << type;
      continue;
    }
    const auto ours = gmsh_element(static_cast<std::uint64_t>(type));
    if (of.node_count == 0 || of.order == 0) continue;  // polygons, polyhedra, and numbers that no file has
    ASSERT_TRUE(ours) << type << ' ' << of.name;
    EXPECT_EQ(ours->node_count, static_cast<std::uint64_t>(of.node_count)) << type;
    const std::map<std::string, std::vector<int>> kinds{{"Line", {3}},
                                                        {"Triangle", {5}},
                                                        {"Quadrilateral", {9}},
                                                        {"Tetrahedron", {10, 24, 71}},
                                                        {"Hexahedron", {12, 25, 29, 72}},
                                                        {"Prism", {13, 26, 32}},
                                                        {"Pyramid", {14, 27, 200}}};
    EXPECT_THAT(kinds.at(of.name.substr(0, of.name.find(' '))), testing::Contains(static_cast<int>(ours->kind)));
    ++known;
  }
  EXPECT_EQ(known, 102);
}

TEST_F(GmshLibrary, orders_the_nodes_of_quadratic_cells_so_that_ours_lie_in_the_middle) {
  for (const int type : {11, 12, 13, 14, 17, 18, 19}) {
    const Properties of = properties(type);
    SCOPED_TRACE(of.name);
    make_model(type, of);
    in_every_form([&](const std::filesystem::path& path) {
      gmsh::write(path.string());
      const CellMesh mesh = read_cells(path, {});
      ASSERT_EQ(mesh.kinds.size(), 1U);
      EXPECT_EQ(mesh.cell_nodes.size(), static_cast<std::size_t>(of.node_count));
      EXPECT_EQ(expect_nodes_in_their_places(mesh, 1e-12),
                static_cast<std::size_t>(of.node_count - corner_count(mesh.kinds[0])));
      EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(42));
      EXPECT_THAT(mesh.cell_fields[1].values, testing::ElementsAre(7));
      EXPECT_EQ(mesh.cell_fields[0].label_names, (formats::LabelNames{{42, "core"}}));
      EXPECT_THAT(mesh.notes, testing::IsEmpty());
    });
  }
}

TEST_F(GmshLibrary, orders_the_nodes_of_higher_cells_so_that_ours_lie_where_vtk_has_them) {
  vtkNew<vtkLagrangeTetra> tetrahedron;
  vtkNew<vtkLagrangeHexahedron> hexahedron;
  for (const int type : {29, 30, 31, 71, 72, 92, 93, 94, 95, 96}) {
    const Properties of = properties(type);
    SCOPED_TRACE(of.name);
    make_model(type, of);
    gmsh::option::setNumber("Mesh.MshFileVersion", 4.1);
    gmsh::write((folder_ / "a.msh").string());
    const CellMesh mesh = read_cells(folder_ / "a.msh", {});
    const bool is_tetrahedron = of.name.starts_with("Tetra");
    ASSERT_EQ(mesh.kinds[0], is_tetrahedron ? CellKind::lagrange_tetrahedron : CellKind::lagrange_hexahedron);
    vtkCell* cell = is_tetrahedron ? static_cast<vtkCell*>(tetrahedron) : static_cast<vtkCell*>(hexahedron);
    cell->PointIds->SetNumberOfIds(of.node_count);
    cell->Points->SetNumberOfPoints(of.node_count);
    if (!is_tetrahedron) hexahedron->SetOrder(of.order, of.order, of.order);
    if (is_tetrahedron) tetrahedron->Initialize();
    const double* expected = cell->GetParametricCoords();
    for (std::size_t i = 0; i < mesh.cell_nodes.size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double found = mesh.points[mesh.cell_nodes[i]][axis];
        EXPECT_NEAR(is_tetrahedron ? found : (found + 1) / 2, expected[3 * i + axis], 1e-9) << "node " << i;
      }
  }
}

TEST_F(GmshLibrary, writes_fields_with_time_steps_that_we_read) {
  const Properties of = properties(11);
  make_model(11, of);
  std::string model;
  gmsh::model::getCurrent(model);
  std::vector<std::size_t> tags;
  for (std::size_t i = 0; i < 10; ++i) tags.push_back(10 + 3 * i);
  const int at_nodes = gmsh::view::add("temperature"), in_cells = gmsh::view::add("flow");
  for (int step = 0; step < 3; ++step) {
    std::vector<double> values;
    for (int i = 0; i < 10; ++i) values.push_back(100 * step + i + 0.1);
    gmsh::view::addHomogeneousModelData(at_nodes, step, model, "NodeData", tags, values, 0.5 * step, 1);
    gmsh::view::addHomogeneousModelData(in_cells, step, model, "ElementData", {5}, {1.5 + step, 2, 3}, 0.5 * step, 3);
  }
  in_every_form([&](const std::filesystem::path& path) {
    gmsh::write(path.string());
    gmsh::view::write(at_nodes, path.string(), true);
    gmsh::view::write(in_cells, path.string(), true);
    for (const int step : {0, 1, 2}) {
      const CellMesh mesh = read_cells(path, {.time = concat("#", step)});
      ASSERT_EQ(mesh.point_fields.size(), 1U);
      EXPECT_EQ(mesh.point_fields[0].name, "temperature");
      for (std::size_t i = 0; i < 10; ++i)
        EXPECT_EQ(mesh.point_fields[0].values[i], 100 * step + static_cast<double>(i) + 0.1);
      EXPECT_EQ(mesh.cell_fields[2].name, "flow");
      EXPECT_THAT(mesh.cell_fields[2].values, testing::ElementsAre(1.5 + step, 2, 3));
    }
  });
}

TEST_F(GmshLibrary, writes_medit_files_that_we_read) {
  for (const int type : {4, 5}) {
    const Properties of = properties(type);
    SCOPED_TRACE(of.name);
    make_model(type, of);
    gmsh::write((folder_ / "a.mesh").string());
    const CellMesh mesh = read_cells(folder_ / "a.mesh", {});
    ASSERT_EQ(mesh.kinds.size(), 1U);
    EXPECT_EQ(static_cast<std::uint8_t>(mesh.kinds[0]), gmsh_element(static_cast<std::uint64_t>(type))->kind);
    ASSERT_EQ(mesh.cell_nodes.size(), static_cast<std::size_t>(of.node_count));
    for (std::size_t i = 0; i < mesh.cell_nodes.size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(mesh.points[mesh.cell_nodes[i]][axis], of.places[3 * i + axis]);
  }
}

/// Whatever stands in a binary file, the answer is an Error or a mesh that holds together.
TEST_F(GmshLibrary, writes_binary_files_whose_damage_we_survive) {
  const Properties of = properties(12);
  make_model(12, of);
  in_every_form([&](const std::filesystem::path& path) {
    gmsh::write(path.string());
    const std::string content = read_file(path);
    check_every_beginning(path, content, [&] { return read_cells(path, {}).cell_nodes.size() == 27; },
                          {.stride = 53, .is_text = true});
    int refused = 0;
    for (std::size_t at = 0; at < content.size(); at += 37)
      for (const char letter : {'\xff', '\0', '7'}) {
        std::string changed = content;
        changed[at] = letter;
        write_file(path, changed);
        try {
          const CellMesh mesh = read_cells(path, {});
          for (const std::uint64_t node : mesh.cell_nodes) ASSERT_LT(node, mesh.points.size());
        } catch (const Error& error) {
          EXPECT_THAT(std::string(error.what()), testing::HasSubstr("a.msh"));
          ++refused;
        }
      }
    EXPECT_GT(refused, 10);
  });
}

}  // namespace
}  // namespace rhoray::preprocess
