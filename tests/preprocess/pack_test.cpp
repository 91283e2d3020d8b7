#include "preprocess/pack.h"

#include <cstdlib>

#include "preprocess/import_mesh.h"
#include "preprocess/resample.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/expect_error.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::ElementsAre;
using testing::HasSubstr;

/// A file of every kind in a folder of its own.
class Pack : public testing::Test {
 protected:
  void SetUp() override {
    ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
    write_file(folder_ / "a.raw", bytes_of_values(known_values<std::uint16_t>()));
    write_file(folder_ / "colors.nrrd",
               "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color domain domain domain\n"
               "encoding: raw\n\n" +
                   std::string(24, 'c'));
    write_file(folder_ / "a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    NeutralMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    mesh.cells = {{0, 1, 2, 3}, {1, 2, 3, 4}};
    mesh.cell_fields = {{"pressure", "", 1, false, {1, 2}}};
    export_mesh(mesh, folder_ / "a.vtu", false);
  }
  PackReport packed(const char* name, const PackOptions& options = {}) const {
    return pack(folder_ / name, folder_ / concat(name, ".rho"), options);
  }
  TemporaryFolder folder_;
};

TEST_F(Pack, takes_every_kind_of_input_and_describes_what_it_wrote) {
  const PackReport volume = packed("a.raw", {.raw = "3x4x5:uint16"});
  EXPECT_EQ(std::get<formats::GridDescription>(volume.description).layout.sample_count, Index3(3, 4, 5));
  EXPECT_EQ(volume.raw_bytes, 3U * 4 * 5 * 2);
  const PackReport colors = packed("colors.nrrd", {.color = true});
  EXPECT_EQ(std::get<formats::ColorGridDescription>(colors.description).component_count, 3);
  EXPECT_EQ(colors.raw_bytes, 24U);
  const PackReport surface = packed("a.off");
  EXPECT_EQ(std::get<formats::TriangleMeshDescription>(surface.description).triangle_count, 1U);
  const PackReport mesh = packed("a.vtu");
  const auto& tets = std::get<formats::TetMeshDescription>(mesh.description);
  EXPECT_EQ(tets.cell_count, 2U);
  ASSERT_EQ(tets.fields.size(), 1U);
  EXPECT_EQ(tets.fields[0].name, "pressure");
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("averaged to the points"), HasSubstr("1 to 2 in cells")));
  for (const PackReport* report : {&volume, &colors, &surface, &mesh}) EXPECT_GT(report->file_bytes, 0U);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "a.vtu.rho"), mesh.file_bytes);
}

TEST_F(Pack, refuses_options_of_another_kind_by_their_names) {
  const auto refused = [&](const char* name, const PackOptions& options, const std::string& words) {
    expect_error(ErrorCode::usage, words, [&] { packed(name, options); });
  };
  refused("a.vtu", {.layout = SampleOrder::bricks}, "--layout: only for volumes, but ");
  refused("a.vtu", {.color = true}, "a.vtu is a mesh");
  refused("a.off", {.fields = {"x"}}, "is a surface, which has no fields");
  refused("a.off", {.cells = 5}, "--cells: only for meshes, but ");
  refused("colors.nrrd", {.structure = MeshStructure::leaves}, "--structure: only for meshes, but ");
  refused("colors.nrrd", {.color = true, .layout = SampleOrder::sparse}, "--layout sparse: cannot be combined");
  refused("a.vtu", {.leaf_ratio = 2.0}, "--leaf-ratio: only for volumes or --structure leaves");
  refused("a.vtu", {.structure = MeshStructure::leaves, .cells = 0}, "--cells: found 0; expected a number from 1");
  refused("colors.nrrd", {.factor = 1}, "--factor: found 1; expected a number from 2 to 1024");
  expect_error(ErrorCode::invalid, "expects 2400", [&] { packed("a.off", {.raw = "100x3x4:uint16"}); });
  expect_error(ErrorCode::unreadable, "no such file", [&] { packed("b.vtu"); });
  expect_error(ErrorCode::unsupported, "already a packed file", [&] {
    packed("a.off");
    packed("a.off.rho");
  });
}

TEST_F(Pack, is_followed_by_resampling_of_the_same_mesh_and_of_the_packed_one) {
  packed("a.vtu");
  const ResampleOptions options{.lattice = {.longest_axis = 9}, .replace_existing = true};
  const ResampleReport foreign = resample(folder_ / "a.vtu", folder_ / "grid.rho", options);
  EXPECT_THAT(foreign.notes, testing::Contains(HasSubstr("averaged to the points")));
  EXPECT_EQ(foreign.description.provenance.source_name, "a.vtu");
  const ResampleReport again = resample(folder_ / "a.vtu.rho", folder_ / "grid.rho", options);
  EXPECT_EQ(again.inside_count, foreign.inside_count);
  expect_error(ErrorCode::unsupported, "holds a surface",
               [&] { resample(folder_ / "a.off", folder_ / "b.rho", options); });
  expect_error(ErrorCode::unsupported, "already a packed grid",
               [&] { resample(folder_ / "grid.rho", folder_ / "b.rho", options); });
}

}  // namespace
}  // namespace rhoray::preprocess
