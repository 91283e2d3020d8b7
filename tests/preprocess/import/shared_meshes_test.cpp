// Real meshes made by others, in the formats whose readers are our own or Gmsh's. Counts stand in
// the README beside the files. Runs where RHORAY_SHARED_DATA names their folder.

#include <cstdlib>

#include "formats/base/interval.h"
#include "preprocess/import_mesh.h"
#include "tests/preprocess/import/node_places.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

class SharedMeshes : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("RHORAY_SHARED_DATA");
    if (folder == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA does not name the folder of real files";
    folder_ = std::filesystem::path(folder) / "unstructured";
    ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  }
  CellMesh cells(const std::string& name, const std::string& time = {}) const {
    return import_cells(folder_ / name, {.time = time});
  }
  std::filesystem::path folder_;
};

std::size_t count_of(const CellMesh& mesh, CellKind kind) {
  return static_cast<std::size_t>(std::count(mesh.kinds.begin(), mesh.kinds.end(), kind));
}

Interval<double> range_of(const std::vector<NeutralField>& fields, const std::string& name) {
  Interval<double> range;
  for (const NeutralField& field : fields)
    if (field.name == name)
      for (const double value : field.values) range.include(value);
  return range;
}

TEST_F(SharedMeshes, holds_an_exodus_reactor_with_fields) {
  const CellMesh mesh = cells("disk_out_ref.ex2");
  EXPECT_EQ(mesh.points.size(), 8499U);
  EXPECT_EQ(count_of(mesh, CellKind::hexahedron), 7472U);
  const Interval<double> temperature = range_of(mesh.point_fields, "Temp");
  EXPECT_NEAR(temperature.lo, 293, 0.5);
  EXPECT_NEAR(temperature.hi, 913, 0.5);
  std::vector<std::string> names;
  for (const NeutralField& field : mesh.point_fields) names.push_back(concat(field.name, ":", field.component_count));
  EXPECT_THAT(names, testing::ElementsAre("Temp:1", "V:3", "Pres:1", "AsH3:1", "GaMe3:1", "CH4:1", "H2:1"));
}

TEST_F(SharedMeshes, holds_exodus_blocks_of_many_kinds) {
  const CellMesh mesh = cells("biplane_rms_pressure_bs.exo");
  for (const CellKind kind :
       {CellKind::hexahedron, CellKind::quadratic_hexahedron, CellKind::tetrahedron, CellKind::quadratic_tetrahedron})
    EXPECT_GT(count_of(mesh, kind), 0U) << static_cast<int>(kind);
  EXPECT_THAT(mesh.notes,
              testing::Contains(testing::HasSubstr("172 lines, 18 quadrilaterals, 506 triangles left out")));
}

/// Straight cells: each middle node lies between its corners, wherever the reader puts it.
TEST_F(SharedMeshes, holds_exodus_cells_whose_middle_nodes_lie_in_the_middle) {
  const std::vector<std::pair<std::string, CellKind>> table{
      {"HEX20", CellKind::quadratic_hexahedron},  {"HEX27", CellKind::triquadratic_hexahedron},
      {"PRISM15", CellKind::quadratic_wedge},     {"PRISM18", CellKind::biquadratic_quadratic_wedge},
      {"PYRAMID13", CellKind::quadratic_pyramid}, {"PYRAMID14", CellKind::quadratic_pyramid_14},
      {"TET10", CellKind::quadratic_tetrahedron}, {"TET14", CellKind::quadratic_tetrahedron_14}};
  for (const auto& [name, kind] : table) {
    SCOPED_TRACE(name);
    const CellMesh mesh = cells(concat("exodus_elements/read_exodus_", name, ".e"));
    EXPECT_GT(count_of(mesh, kind), 0U);
    EXPECT_EQ(count_of(mesh, kind), mesh.kinds.size());
    EXPECT_GT(expect_nodes_in_their_places(mesh, 1e-9), 0U);
  }
}

TEST_F(SharedMeshes, holds_gmsh_files_text_and_binary) {
  const CellMesh heater = cells("gmsh/indheat.bin.v41.msh");
  EXPECT_EQ(heater.points.size(), 5291U);
  EXPECT_EQ(count_of(heater, CellKind::tetrahedron), 30444U);  // as Gmsh says; the README counts 23,017
  EXPECT_GT(range_of(heater.cell_fields, "physical").hi, 0);
  const CellMesh piece = cells("gmsh/piece.asc.v22.msh");
  EXPECT_EQ(piece.points.size(), 3939U);
  EXPECT_EQ(count_of(piece, CellKind::tetrahedron), 13179U);
  EXPECT_THAT(piece.notes, testing::Contains(testing::HasSubstr("852 lines, 6908 triangles, 126 vertices left out")));
  const CellMesh bad = cells("sofa/6_tetra_bad.msh");  // all six carry the number 44
  EXPECT_EQ(bad.points.size(), 17U);
  EXPECT_EQ(count_of(bad, CellKind::tetrahedron), 6U);
}

TEST_F(SharedMeshes, holds_a_netgen_shaft) {
  const CellMesh shaft = cells("netgen/shaft.vol");
  EXPECT_EQ(shaft.points.size(), 949U);
  EXPECT_EQ(count_of(shaft, CellKind::tetrahedron), 2636U);
  EXPECT_THAT(shaft.notes, testing::Contains(testing::HasSubstr("1744 surface elements left out")));
}

TEST_F(SharedMeshes, holds_tetrahedra_of_ten_nodes_from_tetgen_files) {
  const CellMesh cube = cells("tetgen/cube_1626_elements_fully_quadratic.ele");
  EXPECT_EQ(cube.points.size(), 2570U);
  EXPECT_EQ(count_of(cube, CellKind::quadratic_tetrahedron), 1626U);
  EXPECT_EQ(expect_nodes_in_their_places(cube, 1e-5), 6 * 1626U);
}

/// The PLY file was made from the other two by somebody else.
TEST_F(SharedMeshes, holds_a_rabbit_heart_in_binary_tetgen_files) {
  const auto folder = folder_.parent_path() / "surfaces/rabbit_heart";
  const NeutralSurface ply = import_surface(folder / "rabbit_heart.ply");
  const NeutralSurface face = import_surface(folder / "OxfordRabbitHeart_482um.face");
  EXPECT_EQ(face.points.size(), 20118U);
  EXPECT_EQ(face.facet_offsets.size(), 40237U);
  ASSERT_EQ(face.facet_corners.size(), ply.facet_corners.size());
  double farthest = 0;
  for (std::size_t i = 0; i < face.facet_corners.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      farthest = std::max(farthest,
                          std::abs(face.points[face.facet_corners[i]][axis] - ply.points[ply.facet_corners[i]][axis]));
  EXPECT_LT(farthest, 1e-6);  // cm; the PLY file has 32-bit floats
}

}  // namespace
}  // namespace rhoray::preprocess
