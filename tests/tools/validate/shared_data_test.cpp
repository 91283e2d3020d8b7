#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/mesh/position_fields.h"
#include "preprocess/tetrahedralize.h"
#include "tests/tools/validate/support.h"

namespace rhoray::tests {
namespace {

std::optional<std::filesystem::path> shared_data() {
  const char* folder = std::getenv("RHORAY_SHARED_DATA");
  return folder == nullptr ? std::nullopt : std::optional<std::filesystem::path>(folder);
}

#define RHORAY_NEEDS_SHARED_DATA() \
  if (!shared_data()) GTEST_SKIP() << "RHORAY_SHARED_DATA names no folder"

/// A mesh of the shared data with one of its fields.
ValidatedFile mesh_file(const std::string& name, const std::string& field) {
  preprocess::NeutralMesh mesh = preprocess::import_mesh(*shared_data() / "unstructured" / name);
  std::erase_if(mesh.point_fields, [&](const preprocess::NeutralField& each) { return each.name != field; });
  return ValidatedFile(mesh);
}

void expect_all_right(const ValidatedFile& file, double isovalue) {
  const validate::RayQuery query{.isovalue = isovalue, .samples = 5'000};
  const validate::Report report = file.report(query);
  EXPECT_TRUE(report.holds()) << json_of(report).dump(1);
  EXPECT_GT(report.total().hits, 2'000U);
  expect_caught("hits_dropped", file.report(query, dropping_one_hit_in_a_thousand(file.renderer(isovalue))));

  const render::Method certified{.algorithm = render::Method::Algorithm::certified};
  const validate::Report proven = file.report(query, file.renderer(isovalue, certified));
  EXPECT_TRUE(proven.holds()) << json_of(proven).dump(1);
}

TEST(SharedDataValidation, of_the_torso) {
  RHORAY_NEEDS_SHARED_DATA();
  const ValidatedFile file = mesh_file("utahtorso/utahtorso-lowres.vtu", "voltage");
  expect_all_right(file, 60);
  expect_all_right(file, -60);
}

TEST(SharedDataValidation, of_the_blunt_fin_with_its_flat_cells) {
  RHORAY_NEEDS_SHARED_DATA();
  expect_all_right(mesh_file("derived/bluntfin_187395tets.vtu", "Density"), 1.2);
}

TEST(SharedDataValidation, of_the_distance_from_the_rabbit_hearts_walls) {
  RHORAY_NEEDS_SHARED_DATA();
  const auto file = *shared_data() / "surfaces/rabbit_heart/rabbit_heart.ply";
  preprocess::NeutralMesh mesh = preprocess::tetrahedralize(preprocess::import_surface(file));
  preprocess::add_position_fields(mesh);
  ASSERT_EQ(mesh.point_fields.front().name, "boundary_distance");
  mesh.point_fields.resize(1);
  expect_all_right(ValidatedFile(mesh), 0.03);
}

TEST(SharedDataValidation, of_the_tooth) {
  RHORAY_NEEDS_SHARED_DATA();
  expect_all_right(ValidatedFile(preprocess::import_volume(*shared_data() / "volumes/tooth/tooth.nhdr")), 700);
}

}  // namespace
}  // namespace rhoray::tests
