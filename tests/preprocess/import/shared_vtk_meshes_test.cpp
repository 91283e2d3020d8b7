// Real meshes of the VTK family and of PLOT3D, made by others; their sizes stand in the README
// beside the files. Runs where RHORAY_SHARED_DATA names their folder.

#include <cstdlib>
#include <map>
#include <set>

#include "preprocess/import/readers.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/vtk_cells.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::Contains;
using testing::HasSubstr;

class SharedVtkMeshes : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("RHORAY_SHARED_DATA");
    if (folder == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA does not name the folder of real files";
    folder_ = std::filesystem::path(folder) / "unstructured";
  }
  CellMesh read(const std::string& name) { return read_cells(folder_ / name, {}); }

  std::filesystem::path folder_;
};

const NeutralField& field_named(const std::vector<NeutralField>& fields, const std::string& name) {
  for (const NeutralField& field : fields)
    if (field.name == name) return field;
  throw std::runtime_error("no field " + name);
}

TEST_F(SharedVtkMeshes, have_the_cells_that_other_programs_counted) {
  using Census = std::map<int, std::size_t>;
  struct Row {
    std::string name;
    std::size_t points;
    Census cells;  ///< by VTK's number
  };
  for (const Row& row :
       std::vector<Row>{{"can.vtu", 6724, {{12, 4800}}},
                        {"reservoir/UNISIM-II-D.vtu", 58433, {{12, 47610 - 14775}}},  // vtkGhostType: hidden
                        {"CylinderQuadratic.vtk", 2814, {{24, 1522}}},
                        {"AngularSector.vtk", 10141, {{12, 7632}, {14, 144}}},
                        {"PentaHexa.vtk", 401, {{15, 60}, {16, 150}}},
                        {"office.binary.vtk", 8400, {{12, 7220}}},
                        {"post_subset.vtk", 2288, {{10, 8750}}},
                        {"plot3d/postxyz.bin", 109744, {{12, 102675}}},
                        {"plot3d/postq.bin", 109744, {{12, 102675}}},
                        {"plot3d/bluntfinxyz.bin", 40960, {{12, 37479}}},
                        {"plot3d/bluntfinq.bin", 40960, {{12, 37479}}}}) {
    SCOPED_TRACE(row.name);
    EXPECT_EQ(foreign_kind(folder_ / row.name), ForeignKind::mesh);
    const CellMesh mesh = read(row.name);
    EXPECT_EQ(mesh.points.size(), row.points);
    Census census;
    for (const CellKind kind : mesh.kinds) ++census[static_cast<int>(kind)];
    EXPECT_EQ(census, row.cells);
  }
}

TEST_F(SharedVtkMeshes, keep_the_fields_that_other_programs_measured) {
  const auto expect_range = [](const NeutralField& field, double lowest, double highest, double tolerance) {
    EXPECT_NEAR(*std::min_element(field.values.begin(), field.values.end()), lowest, tolerance) << field.name;
    EXPECT_NEAR(*std::max_element(field.values.begin(), field.values.end()), highest, tolerance) << field.name;
  };
  expect_range(field_named(read("can.vtu").cell_fields, "EQPS"), 0.02, 2.89, 0.006);
  expect_range(field_named(read("reservoir/UNISIM-II-D.vtu").cell_fields, "BLOCK_J"), 0, 68, 0);
  expect_range(field_named(read("CylinderQuadratic.vtk").point_fields, "pressure"), -98, 7234, 0.6);
  expect_range(field_named(read("PentaHexa.vtk").point_fields, "scalar2"), 0, 1, 0.02);
  expect_range(field_named(read("office.binary.vtk").point_fields, "scalars"), -3.87, 0.72, 0.006);
}

/// 4 pieces of 48,823 points together; whatever coincides exactly across them is one point
/// afterwards.
TEST_F(SharedVtkMeshes, merge_the_interfaces_of_the_blood_vessels) {
  const CellMesh mesh = read("blood_vessels/T0000000500.pvtu");
  EXPECT_EQ(mesh.kinds.size(), 39353U);
  EXPECT_EQ(mesh.kinds.front(), CellKind::voxel);
  const std::set<std::array<double, 3>> places(mesh.points.begin(), mesh.points.end());
  EXPECT_EQ(mesh.points.size(), places.size());
  EXPECT_LT(mesh.points.size(), 48823U);
  EXPECT_THAT(mesh.notes, Contains(HasSubstr(concat(48823U - mesh.points.size(), " points merged"))));
  const NeutralField& density = field_named(mesh.cell_fields, "density");
  EXPECT_NEAR(*std::min_element(density.values.begin(), density.values.end()), 0.22, 0.006);
  EXPECT_NEAR(*std::max_element(density.values.begin(), density.values.end()), 0.52, 0.006);
  std::size_t points = 0;
  for (const char* piece : {"000", "001", "002", "003"})
    points += read(concat("blood_vessels/T0000000500/", piece, ".vtu")).points.size();
  EXPECT_EQ(points, 48823U);
}

/// Every hexahedron is made of five of the tetrahedra: each of these spans one step along each
/// axis.
void expect_five_tetrahedra_in_each(const CellMesh& hexahedra, const CellMesh& tetrahedra, const Index3& sizes) {
  std::map<std::uint64_t, int> tetrahedra_at;  ///< by the number of the lowest corner of the step
  const auto nx = static_cast<std::uint64_t>(sizes[0]), ny = static_cast<std::uint64_t>(sizes[1]);
  for (std::size_t cell = 0; cell < tetrahedra.kinds.size(); ++cell) {
    std::array<std::uint64_t, 3> lowest{~0UL, ~0UL, ~0UL}, highest{0, 0, 0};
    for (const std::uint64_t node : nodes_of(tetrahedra, cell)) {
      const std::array<std::uint64_t, 3> at{node % nx, node / nx % ny, node / (nx * ny)};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lowest[axis] = std::min(lowest[axis], at[axis]);
        highest[axis] = std::max(highest[axis], at[axis]);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_EQ(highest[axis], lowest[axis] + 1);
    ++tetrahedra_at[lowest[0] + nx * (lowest[1] + ny * lowest[2])];
  }
  ASSERT_EQ(tetrahedra_at.size(), hexahedra.kinds.size());
  for (std::size_t cell = 0; cell < hexahedra.kinds.size(); ++cell)
    ASSERT_EQ(tetrahedra_at[nodes_of(hexahedra, cell)[0]], 5) << "hexahedron " << cell;
}

/// The derived meshes were made by another program from the same PLOT3D files, with the points in
/// the same order.
TEST_F(SharedVtkMeshes, of_plot3d_agree_with_what_vtk_made_of_them) {
  struct Row {
    std::string plot3d, derived;
    Index3 sizes;
  };
  for (const auto& [plot3d, derived, sizes] :
       std::vector<Row>{{"plot3d/postxyz.bin", "derived/post_513375tets.vtu", {38, 76, 38}},
                        {"plot3d/bluntfinxyz.bin", "derived/bluntfin_187395tets.vtu", {40, 32, 32}}}) {
    SCOPED_TRACE(plot3d);
    const CellMesh mesh = read(plot3d), other = read(derived);
    EXPECT_EQ(mesh.points, other.points);
    for (const NeutralField& field : other.point_fields) {
      SCOPED_TRACE(field.name);
      const NeutralField& ours = field_named(mesh.point_fields, field.name);
      EXPECT_EQ(ours.component_count, field.component_count);
      EXPECT_EQ(ours.values, field.values);
    }
    expect_five_tetrahedra_in_each(mesh, other, sizes);
  }
}

TEST_F(SharedVtkMeshes, that_are_broken_are_refused) {
  expect_refusal([&] { read("sofa/Armadillo_Tetra_4406_for_test_broken.vtu"); }, ErrorCode::invalid, {"Armadillo"});
}

}  // namespace
}  // namespace rhoray::preprocess
