#include <cstdlib>

#include "preprocess/import/readers.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/sanitizers.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

class Import : public testing::Test {
 protected:
  void SetUp() override { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }
  TemporaryFolder folder_;
};

NeutralMesh small_mesh() {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.1}};
  mesh.cells = {{0, 1, 2, 3}};
  mesh.point_fields = {{"voltage", "", 1, false, {1, 2, 3, 0.1}}};
  return mesh;
}

TEST_F(Import, reads_a_volume_in_a_process_of_its_own) {
  const auto path = folder_ / "a name with spaces.bin";
  write_file(path, concat("x", bytes_of_values(known_values<float>(), true)));
  ImportVolumeOptions options;
  options.raw = parse_raw_volume("3x4x5:float32:be:1");
  const NeutralVolume volume = import_volume(path, options);
  expect_known_values(volume, ElementType::F32);
  EXPECT_TRUE(volume.owned_samples.empty());  // they stay where the worker put them
}

TEST_F(Import, replaces_spacing_and_origin_and_keeps_directions) {
  const auto path = folder_ / "a.nrrd";
  write_file(path,
             "NRRD0004\ntype: uchar\ndimension: 3\nspace dimension: 3\nsizes: 3 4 5\nspace directions: (0,2,0) "
             "(-3,0,0) (0,0,-1)\n"
             "space origin: (7,8,9)\nencoding: raw\n\n" +
                 bytes_of_values(known_values<std::uint8_t>()));
  expect_map(import_volume(path).world_from_grid, {{0, 2, 0}, {-3, 0, 0}, {0, 0, -1}, {7, 8, 9}});
  ImportVolumeOptions options;
  options.spacing = Vec3(0.5, 1.5, 2.5);
  expect_map(import_volume(path, options).world_from_grid, {{0, 0.5, 0}, {-1.5, 0, 0}, {0, 0, -2.5}, {7, 8, 9}});
  options.origin = Vec3(1, 2, 3);
  expect_near(import_volume(path, options).world_from_grid.origin, {1, 2, 3});
  options.spacing = Vec3(0, 1, 1);
  expect_refusal([&] { import_volume(path, options); }, ErrorCode::usage, {"spacing"});
  options = {};
  options.origin = Vec3(NAN, 0, 0);
  expect_refusal([&] { import_volume(path, options); }, ErrorCode::usage, {"origin"});
}

TEST_F(Import, passes_the_readers_refusals_on) {
  const auto path = folder_ / "a.nrrd";
  write_file(path, "junk");
  expect_refusal([&] { import_volume(path); }, ErrorCode::invalid, {"a.nrrd, byte 0"});
  expect_refusal([&] { import_volume(folder_ / "none.vti"); }, ErrorCode::unreadable, {"none.vti"});
  expect_refusal([&] { import_mesh(folder_ / "none.vtu"); }, ErrorCode::unreadable, {"none.vtu"});
  expect_refusal([&] { import_volume(folder_ / "a.xyz0"); }, ErrorCode::unsupported, {"'.xyz0'", ".nrrd"});
  expect_refusal([&] { import_mesh(folder_ / "a.stl"); }, ErrorCode::unsupported, {"'.stl'", ".vtu"});
  expect_refusal([&] { import_surface(folder_ / "a.vtu"); }, ErrorCode::unsupported, {"'.vtu'", ".ply"});
}

TEST_F(Import, stops_a_reader_that_needs_too_much_memory) {
  if (tests::sanitized) GTEST_SKIP() << tests::no_limits_of_memory;
  const auto path = folder_ / "a.raw";
  write_file(path, "");
  std::filesystem::resize_file(path, 2U << 30);  // a hole: no disk is used
  ImportVolumeOptions options;
  options.raw = parse_raw_volume("1024x1024x1024:uint16:be");
  options.memory_limit_bytes = 1U << 30;  // the file is mapped, its copy in our order does not fit
  expect_refusal([&] { import_volume(path, options); }, ErrorCode::resource, {"a.raw", "memory"});
}

TEST_F(Import, reads_meshes_and_surfaces_in_a_process_of_their_own) {
  write_file(folder_ / "a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n");
  write_file(folder_ / "a.ele", "1 4 0\n0 0 1 2 3\n");
  EXPECT_EQ(import_mesh(folder_ / "a.ele").cells.size(), 1U);
  write_file(folder_ / "a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  write_file(folder_ / "s.mtr", "3 1\n1\n2\n3\n");
  const NeutralSurface surface = import_surface(folder_ / "a.off", folder_ / "s.mtr");
  EXPECT_THAT(surface.facet_corners, testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(surface.point_sizes, testing::ElementsAre(1, 2, 3));
}

TEST_F(Import, writes_a_mesh_that_it_reads_again) {
  const auto path = folder_ / "a.vtu";
  export_mesh(small_mesh(), path, false);
  const NeutralMesh read = import_mesh(path);
  EXPECT_EQ(read.points, small_mesh().points);
  EXPECT_EQ(read.point_fields[0].values, small_mesh().point_fields[0].values);
  EXPECT_NE(std::filesystem::status(path).permissions() & std::filesystem::perms::group_read,
            std::filesystem::perms::none);
}

TEST_F(Import, replaces_an_existing_file_only_when_told_to_and_leaves_nothing_behind) {
  const auto path = folder_ / "a.vtu";
  write_file(path, "precious");
  expect_refusal([&] { export_mesh(small_mesh(), path, false); }, ErrorCode::usage, {"a.vtu"});
  NeutralMesh broken = small_mesh();
  broken.cells[0][3] = 4;
  expect_refusal([&] { export_mesh(broken, path, true); }, ErrorCode::invalid, {"point 4"});
  EXPECT_EQ(read_file(path), "precious");
  export_mesh(small_mesh(), path, true);
  EXPECT_EQ(import_mesh(path).cells.size(), 1U);
  expect_refusal([&] { export_mesh(small_mesh(), folder_ / "none/a.vtu", false); }, ErrorCode::usage,
                 {"a.vtu", "No such file"});
  expect_refusal([&] { export_mesh(small_mesh(), folder_ / "a.vtk", false); }, ErrorCode::usage, {".vtu"});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(Import, says_what_to_do_with_formats_that_it_knows_and_does_not_read) {
  EXPECT_THAT(advice_on("x/Aneurysm.LVS.fld"), testing::HasSubstr("--raw 64x64x64:int32:be:524"));
  EXPECT_THAT(advice_on("torso.tvt.fld"), testing::HasSubstr(".vtu"));
  EXPECT_THAT(advice_on("a.cgns"), testing::HasSubstr("meshio"));
  EXPECT_THAT(advice_on("a.h5"), testing::HasSubstr(".xdmf"));
  EXPECT_THAT(advice_on("a.pvtp"), testing::HasSubstr("with ParaView (Save Data)"));
  EXPECT_EQ(advice_on("a.vtu"), "");
  EXPECT_EQ(advice_on("fld"), "");
  try {
    import_mesh(folder_ / "torso.tvt.fld");
    ADD_FAILURE() << "nothing was refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.hint(), advice_on("torso.tvt.fld"));
  }
}

/// Nothing that is read needs advice, and the other way round.
TEST_F(Import, gives_no_advice_on_what_it_reads) {
  for (const char* name : {"a.fld", "a.lvs.fld", "a.h5", "a.cgns", "a.vtm", "a.pvd", "a.pvtp", "a.step", "a.geo",
                           "a.vol.gz", "a.nrrd.gz", "a.sol", "a.hdr"})
    EXPECT_EQ(foreign_kind(name), ForeignKind::unknown) << name;
}

/// The table that answers what a file holds and the table that reads it must name the same
/// extensions.
TEST_F(Import, reads_every_extension_whose_kind_it_knows) {
  const auto knows = [](const std::function<void()>& read) {
    try {
      read();
    } catch (const Error& error) {
      return error.code() != ErrorCode::unsupported;
    }
    return true;
  };
  std::vector<std::string> extensions{".NRRD", ".Nii.Gz", ".gz", ".rho", ".pvd", ""};
  for (const ForeignFormat& format : foreign_formats())
    for (const std::string_view family : format.families)
      // Content decides; other programs read pictures and OpenVDB.
      if (family.starts_with('.') && family != ".vtk" && !format.name.starts_with("VTKHDF") && format.name != "XDMF" &&
          format.name != "PLOT3D" && format.name != "Pictures" && format.name != "OpenVDB")
        extensions.emplace_back(family);
  EXPECT_GT(extensions.size(), 40U);
  for (const std::string& extension : extensions) {
    const auto path = folder_ / concat("none", extension);
    EXPECT_EQ(foreign_kind(path) == ForeignKind::volume, knows([&] { read_volume(path, {}); })) << extension;
    EXPECT_EQ(foreign_kind(path) == ForeignKind::mesh, knows([&] { read_mesh(path); })) << extension;
    EXPECT_EQ(foreign_kind(path) == ForeignKind::surface, knows([&] { read_surface(path); })) << extension;
  }
}

}  // namespace
}  // namespace rhoray::preprocess
