// Real files made by others. Sizes and ranges were measured with other programs (VTK, meshio,
// nibabel, numpy) and stand in the README beside the files. Runs where RHORAY_SHARED_DATA names
// their folder.

#include <cstdlib>
#include <map>

#include "formats/base/interval.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/mesh/subdivide/cell_kinds.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/conformity.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

class SharedData : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("RHORAY_SHARED_DATA");
    if (folder == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA does not name the folder of real files";
    folder_ = folder;
    ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  }
  std::filesystem::path folder_;
};

struct Expected {
  std::string path;
  Index3 size;
  ElementType type;
  double lowest, highest;
  Affine map;
};

TEST_F(SharedData, holds_volumes_of_known_size_range_and_place) {
  const auto parallel = [](double x, double y, double z, const Vec3& origin = {0, 0, 0}) {
    return axis_parallel_map({x, y, z}, origin);
  };
  const std::vector<Expected> table{
      {"andrei_thorax_ct/andrei_thorax_ct.nhdr",
       {512, 512, 275},
       ElementType::U16,
       0,
       2979,
       parallel(0.78125, 0.78125, 1, {-201, -59, -679.800049})},
      {"vhf_ct_head/vhf_ct_head.nhdr", {512, 512, 234}, ElementType::U8, 0, 255, parallel(0.9766, 0.9766, 1)},
      {"tooth/tooth.nhdr", {103, 94, 161}, ElementType::U16, 0, 1300, parallel(1, 1, 1)},
      {"headsq/quarter.nhdr", {64, 64, 93}, ElementType::I16, 0, 3926, parallel(3.2, 3.2, 1.5)},
      {"MRHeadResampled/MRHeadResampled.nhdr",
       {130, 130, 68},
       ElementType::I16,
       0,
       463,
       parallel(2, 2, 2, {-130, -119.9, -73.7})},
      {"engine.nii.gz", {256, 256, 128}, ElementType::U8, 0, 255, parallel(1, 1, 1)},
      {"fuel.nii.gz", {64, 33, 32}, ElementType::U8, 0, 255, parallel(1, 1, 1)},
      {"inia19-t1-brain.nii.gz", {168, 206, 128}, ElementType::F32, 0, 383.18, parallel(0.5, 0.5, 0.5)},
      {"seg3d_MR.nii.gz", {160, 232, 160}, ElementType::F32, 0, 512, parallel(1, 0.898, 0.898)},
      {"ironProt.vtk", {68, 68, 68}, ElementType::U8, 0, 255, parallel(1, 1, 1)},
      {"carotid.vtk", {76, 49, 45}, ElementType::F32, 0, 580, parallel(1, 1, 1, {100, 80, 1})},
      {"HeadMRVolume.mhd", {48, 62, 42}, ElementType::U8, 0, 255, parallel(4, 4, 4)},
      {"frogtissue/frogtissue.mhd", {500, 470, 136}, ElementType::U8, 0, 29, parallel(1, 1, 1.5)},
  };
  for (const Expected& row : table) {
    SCOPED_TRACE(row.path);
    const NeutralVolume volume = import_volume(folder_ / "volumes" / row.path);
    EXPECT_EQ(volume.sample_count, row.size);
    EXPECT_EQ(formats::element_name(volume.type), formats::element_name(row.type));
    Interval<double> range;
    formats::with_element_type(volume.type, [&]<class T>(T) {
      const auto* samples = reinterpret_cast<const T*>(volume.samples.data());
      Interval<T> found;
      for (std::size_t i = 0; i < volume.samples.size() / sizeof(T); ++i) found.include(samples[i]);
      range = {static_cast<double>(found.lo), static_cast<double>(found.hi)};
    });
    EXPECT_NEAR(range.lo, row.lowest, 0.005);
    EXPECT_NEAR(range.hi, row.highest, 0.005);
    const Affine& map = volume.world_from_grid;
    EXPECT_NEAR(map.x_axis.length(), row.map.x_axis.length(), 5e-4);
    EXPECT_NEAR(map.y_axis.length(), row.map.y_axis.length(), 5e-4);
    EXPECT_NEAR(map.z_axis.length(), row.map.z_axis.length(), 5e-4);
    if (row.path.find(".nii") == std::string::npos) expect_map(map, row.map, 1e-9);
  }
}

TEST_F(SharedData, holds_a_volume_of_colours_that_needs_no_choice) {
  const auto path = folder_ / "volumes/vase_4comp.vti";
  const NeutralVolume shown = import_volume(path);
  EXPECT_EQ(shown.field_name, "Scalars_.mag");
  EXPECT_THAT(shown.notes, testing::ElementsAre("using the magnitude of 4 components, 'Scalars_.mag'; choose another "
                                                "with --field: Scalars_.0, Scalars_.1, Scalars_.2, Scalars_.3"));
  ImportVolumeOptions options;
  options.field = "Scalars_.3";
  EXPECT_EQ(import_volume(path, options).sample_count, Index3(115, 101, 75));
}

TEST_F(SharedData, holds_headerless_volumes) {
  ImportVolumeOptions options;
  options.raw = parse_raw_volume("50x50x50:float32:le");
  const std::vector<double> values = values_of(import_volume(folder_ / "volumes/chi_chunk_50x50x50_f32.bov", options));
  EXPECT_NEAR(*std::min_element(values.begin(), values.end()), 44.7, 0.05);
  EXPECT_NEAR(*std::max_element(values.begin(), values.end()), 1.035e8, 5e4);
  options.raw = parse_raw_volume("64x64x64:int32:be:524");
  const std::vector<double> aneurysm =
      values_of(import_volume(folder_ / "volumes/aneurysm-mra-lowres.lvs.fld", options));
  EXPECT_EQ(*std::min_element(aneurysm.begin(), aneurysm.end()), 0);
  EXPECT_EQ(*std::max_element(aneurysm.begin(), aneurysm.end()), 181);
}

struct ExpectedMesh {
  std::string path;
  std::size_t points, cells;
  std::string field;  ///< of points; empty = none to check
  double lowest, highest, tolerance;
};

TEST_F(SharedData, holds_meshes_of_known_size_and_range) {
  const std::vector<ExpectedMesh> table{
      {"utahtorso/utahtorso-lowres.vtu", 8278, 51419, "voltage", -5058.9, 1780.3, 0.06},
      {"bracket_appended_compressed.vtu", 50000, 206208, "xdsp", -9.5e-9, 3.24e-7, 5e-10},
      {"derived/post_513375tets.vtu", 109744, 513375, "StagnationEnergy", -0.54, 4.40, 0.006},
      {"derived/bluntfin_187395tets.vtu", 40960, 187395, "Density", 0.193, 4.978, 0.0006},
      {"post_subset.vtk", 2288, 8750, "Pressure", 0.355, 1.641, 0.0006},
      {"heart_decimation.vtu", 173, 610, "Distance from origin", 0.57, 2.09, 0.006},
      {"mixed_mesh_3d.vtu", 387, 1298, "", 0, 0, 0},
      {"monodomain3d_0.vtu", 847, 3600, "", 0, 0, 0},
      {"sofa/Ossicles.vtu", 1733, 5058, "", 0, 0, 0},
      {"tetgen/UCSD_heart_decimated_173nodes.node", 173, 610, "", 0, 0, 0},
      {"tetgen/UCSD_heart_decimated_173nodes.ele", 173, 610, "", 0, 0, 0},
  };
  for (const ExpectedMesh& row : table) {
    SCOPED_TRACE(row.path);
    const NeutralMesh mesh = import_mesh(folder_ / "unstructured" / row.path);
    EXPECT_EQ(mesh.points.size(), row.points);
    EXPECT_EQ(mesh.cells.size(), row.cells);
    if (row.field.empty()) continue;
    const auto field = std::find_if(mesh.point_fields.begin(), mesh.point_fields.end(),
                                    [&](const NeutralField& f) { return f.name == row.field; });
    ASSERT_NE(field, mesh.point_fields.end());
    EXPECT_NEAR(*std::min_element(field->values.begin(), field->values.end()), row.lowest, row.tolerance);
    EXPECT_NEAR(*std::max_element(field->values.begin(), field->values.end()), row.highest, row.tolerance);
  }
}

TEST_F(SharedData, keeps_vectors_cell_fields_and_notes) {
  const NeutralMesh post = import_mesh(folder_ / "unstructured/derived/post_513375tets.vtu");
  EXPECT_EQ(post.point_fields[2].name, "Momentum");
  EXPECT_EQ(post.point_fields[2].component_count, 3);
  const NeutralMesh torso = import_mesh(folder_ / "unstructured/utahtorso/utahtorso-lowres.vtu");
  ASSERT_EQ(torso.cell_fields.size(), 1U);
  EXPECT_EQ(torso.cell_fields[0].name, "tissue");
  const NeutralMesh cables = import_mesh(folder_ / "unstructured/mixed_mesh_3d.vtu");
  EXPECT_THAT(cables.notes, testing::Contains(testing::HasSubstr("5 lines left out")));
  EXPECT_EQ(cables.cell_fields[0].values.size(), 1298U);
}

/// How often each face of the linear cells of a mesh is there, by its sorted corners: the outside
/// has those met once.
std::size_t outer_triangles_of(const CellMesh& mesh) {
  std::map<std::vector<std::uint64_t>, std::pair<int, std::size_t>> faces;
  for (std::size_t c = 0; c < mesh.kinds.size(); ++c)
    for (const CellFace& face : frame_of(mesh.kinds[c]).faces) {
      std::vector<std::uint64_t> corners;
      for (std::size_t i = 0; i < face.corner_count; ++i)
        corners.push_back(mesh.cell_nodes[mesh.cell_offsets[c] + face.corners[i]]);
      std::sort(corners.begin(), corners.end());
      corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
      if (corners.size() < 3) continue;
      auto& [times, triangles] = faces[corners];
      ++times;
      triangles = corners.size() - 2;
    }
  std::size_t count = 0;
  for (const auto& [corners, face] : faces) count += face.first == 1 ? face.second : 0;
  return count;
}

TEST_F(SharedData, holds_meshes_of_other_cells_whose_tetrahedra_agree_on_their_faces) {
  struct Row {
    std::string path;
    std::size_t tets;
    std::vector<std::string> notes;
  };
  for (const Row& row :
       std::vector<Row>{{"can.vtu",
                         28836,
                         {"4,800 hexahedra became 28,836 tetrahedra", "6 points added inside cells",
                          "33 cells have no inner point"}},
                        {"AngularSector.vtk", 0, {"7,632 hexahedra became ", "144 pyramids became 288 tetrahedra"}},
                        {"PentaHexa.vtk", 0, {"60 pentagonal prisms became ", "150 hexagonal prisms became "}},
                        {"reservoir/UNISIM-II-D.vtu", 0, {"32,835 hexahedra became "}},
                        {"blood_vessels/T0000000500/000.vtu", 0, {"voxels became "}}}) {
    SCOPED_TRACE(row.path);
    const CellMesh cells = import_cells(folder_ / "unstructured" / row.path);
    const NeutralMesh mesh = import_mesh(folder_ / "unstructured" / row.path);
    if (row.tets != 0) {
      EXPECT_EQ(mesh.cells.size(), row.tets);
    }
    for (const std::string& note : row.notes) EXPECT_THAT(mesh.notes, testing::Contains(testing::HasSubstr(note)));
    const FaceCensus census = census_of_faces(mesh);
    EXPECT_EQ(census.crowded, 0U);
    EXPECT_EQ(census.outer.size(), outer_triangles_of(cells));
  }
}

/// Six times the volume of a hexahedron whose faces are the bilinear patches through their corners:
/// the mean over the two ways to cut each face by a diagonal, as seen from a point (Davies and
/// Salmond, AIAA J. 23, 1985).
double hexahedron_volume6(const CellMesh& mesh, std::size_t cell) {
  constexpr std::size_t faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                       {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  const std::uint64_t* const nodes = mesh.cell_nodes.data() + mesh.cell_offsets[cell];
  const Vec3 from = to_vec3(mesh.points[nodes[0]]);
  const auto corner = [&](std::size_t i) { return to_vec3(mesh.points[nodes[i]]) - from; };
  double sum = 0;
  for (const auto& f : faces) {
    const Vec3 a = corner(f[0]), b = corner(f[1]), c = corner(f[2]), d = corner(f[3]);
    sum += (a.cross(b).dot(c) + a.cross(c).dot(d) + a.cross(b).dot(d) + b.cross(c).dot(d)) / 2;
  }
  return sum;
}

/// The classic curvilinear meshes: their tetrahedra share every inner face two by two, from its two
/// sides, and together are as large as the hexahedra.
TEST_F(SharedData, holds_curvilinear_meshes_whose_tetrahedra_fill_their_hexahedra) {
  struct Row {
    const char* path;
    std::size_t hexahedra;
  };
  for (const Row& row : {Row{"plot3d/postxyz.bin", 102675}, Row{"plot3d/bluntfinxyz.bin", 37479}}) {
    SCOPED_TRACE(row.path);
    const CellMesh cells = import_cells(folder_ / "unstructured" / row.path);
    ASSERT_EQ(cells.kinds.size(), row.hexahedra);
    double of_hexahedra = 0;
    for (std::size_t c = 0; c < cells.kinds.size(); ++c) of_hexahedra += hexahedron_volume6(cells, c) / 6;
    const NeutralMesh mesh = import_mesh(folder_ / "unstructured" / row.path);
    const FaceCensus census = census_of_faces(mesh);
    EXPECT_EQ(census.crowded, 0U);
    EXPECT_EQ(census.outer.size(), outer_triangles_of(cells));
    EXPECT_EQ(census.one_side, 0U);
    EXPECT_EQ(2 * census.inner + census.outer.size(), 4 * mesh.cells.size());
    // Sums of 100,000 terms in double; faces of the boundary are flat enough that two triangles
    // take as much as a patch.
    EXPECT_NEAR(std::abs(of_hexahedra / mesh_volume(mesh)), 1, 1e-9);
  }
}

TEST_F(SharedData, holds_a_mesh_of_quadratic_tetrahedra) {
  const NeutralMesh coarse = import_mesh(folder_ / "unstructured/CylinderQuadratic.vtk", {.max_error = 0.05});
  const NeutralMesh fine = import_mesh(folder_ / "unstructured/CylinderQuadratic.vtk", {.max_error = 0.02});
  EXPECT_GE(coarse.cells.size(), 1522U);
  EXPECT_GT(fine.cells.size(), coarse.cells.size());
  for (const NeutralMesh* mesh : {&coarse, &fine}) {
    const FaceCensus census = census_of_faces(*mesh);
    EXPECT_EQ(census.crowded + census.one_side, 0U);
    EXPECT_THAT(mesh->notes, testing::Contains(testing::StartsWith("1,522 quadratic tetrahedra became ")));
    EXPECT_THAT(mesh->notes, testing::Contains(testing::HasSubstr("of field \"velocity\" 0.0")));
  }
}

TEST_F(SharedData, refuses_what_is_broken_or_not_yet_read) {
  const auto refuses = [&](const std::string& path, ErrorCode error_code, const std::vector<std::string>& words) {
    SCOPED_TRACE(path);
    expect_refusal([&] { import_mesh(folder_ / "unstructured" / path); }, error_code, words);
  };
  refuses("sofa/Armadillo_Tetra_4406_for_test_broken.vtu", ErrorCode::invalid, {"Armadillo"});
}

TEST_F(SharedData, holds_surfaces_of_known_size) {
  struct Row {
    std::string path;
    std::size_t points, facets;
  };
  for (const Row& row : std::vector<Row>{{"surfaces/rabbit_heart/rabbit_heart.ply", 20118, 40236},
                                         {"surfaces/turbineblade.ply", 99519, 199034},
                                         {"surfaces/lungs/rll.stl", 20939, 41874},
                                         {"surfaces/lungs/lul.stl", 22300, 44596},
                                         {"surfaces/gears.stl", 9723, 19426},
                                         {"surfaces/42400-IDGH.stl", 5500, 11036},
                                         {"surfaces/thingi10k/520644.stl", 3919, 7834},
                                         {"surfaces/odedstein/skull.obj", 49999, 100002},
                                         {"surfaces/odedstein/wingnut.obj", 3047, 6090},
                                         {"surfaces/manifold/self_intersectA.obj", 8582, 17160},
                                         {"surfaces/manifold/Cray_left.obj", 292, 576},
                                         {"surfaces/tetgen_example.poly", 28, 24},
                                         {"unstructured/utahtorso/utahtorso-lowres-heart.ply", 1329, 2654}}) {
    SCOPED_TRACE(row.path);
    const NeutralSurface surface = import_surface(folder_ / row.path);
    EXPECT_EQ(surface.points.size(), row.points);
    EXPECT_EQ(surface.facet_offsets.size() - 1, row.facets);
  }
  const NeutralSurface example = import_surface(folder_ / "surfaces/tetgen_example.poly");
  EXPECT_EQ(example.facet_faces.back(), 22U);  // 23 facets, one of two polygons
  EXPECT_EQ(example.openings.size(), 1U);
  EXPECT_EQ(example.holes.size(), 2U);
  EXPECT_EQ(example.regions.size(), 2U);
}

}  // namespace
}  // namespace rhoray::preprocess
