#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/base/text.h"
#include "tests/support/conformity.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

/// Two cubes side by side, a pyramid on one, and a line; with fields of points and cells.
void make_mixed_vtk(const Workbench& bench) {
  write_file(bench / "mixed.vtk",
             "# vtk DataFile Version 3.0\nmixed\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 13 double\n"
             "0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 1 1 1 2 1 1 0.5 0.5 2\n"
             "CELLS 4 27\n2 0 1\n8 0 1 4 3 6 7 10 9\n8 1 2 5 4 7 8 11 10\n5 6 7 10 9 12\n"
             "CELL_TYPES 4\n3 12 12 14\n"
             "POINT_DATA 13\nSCALARS warmth double\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11 12\n"
             "SCALARS colour double\nLOOKUP_TABLE default\n0 0 0 0 0 0 0 0 0 0 0 0 1\n"
             "CELL_DATA 4\nSCALARS block double\nLOOKUP_TABLE default\n9 1 2 3\n");
}

/// One quadratic tetrahedron with one edge bent.
void make_bent_vtk(const Workbench& bench) {
  write_file(bench / "bent.vtk",
             "# vtk DataFile Version 3.0\nbent\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 double\n"
             "0 0 0 1 0 0 0 1 0 0 0 1 0.5 -0.3 0 0.5 0.5 0 0 0.5 0 0 0 0.5 0.5 0 0.5 0 0.5 0.5\n"
             "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n"
             "POINT_DATA 10\nSCALARS f double\nLOOKUP_TABLE default\n0 1 0 0 0.9 0.2 0 0 0 0.7\n");
}

TEST(ImportCommand, makes_tetrahedra_of_other_cells_and_says_what_it_did) {
  const Workbench bench;
  make_mixed_vtk(bench);
  const RunResult run = bench.rhoray({"import", "mixed.vtk", "-o", "tets.vtu", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("2 hexahedra became 12 tetrahedra"));
  EXPECT_THAT(run.err, HasSubstr("1 pyramid became 2 tetrahedra"));
  EXPECT_THAT(run.err, HasSubstr("1 line left out"));
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["cells"], 14);

  const preprocess::NeutralMesh mesh = preprocess::import_mesh(bench / "tets.vtu");
  ASSERT_EQ(mesh.cells.size(), 14U);
  EXPECT_NEAR(mesh_volume(mesh), 2 + 1 / 3.0, 1e-12);
  EXPECT_EQ(census_of_faces(mesh).crowded, 0U);
  ASSERT_EQ(mesh.cell_fields.size(), 2U);
  EXPECT_EQ(mesh.cell_fields[1].name, "source_cell");
  for (std::size_t t = 0; t < 14; ++t)
    EXPECT_EQ(mesh.cell_fields[1].values[t], mesh.cell_fields[0].values[t]) << "cells 1 to 3 are in blocks 1 to 3";
}

TEST(ImportCommand, keeps_the_fields_asked_for) {
  const Workbench bench;
  make_mixed_vtk(bench);
  const RunResult run = bench.rhoray({"import", "mixed.vtk", "-o", "tets.vtu", "--field", "warmth"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("left out: \"colour\", \"block\""));
  const preprocess::NeutralMesh mesh = preprocess::import_mesh(bench / "tets.vtu");
  ASSERT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(mesh.point_fields[0].name, "warmth");

  const RunResult refused = bench.rhoray({"import", "mixed.vtk", "-o", "x.vtu", "--field", "warmht"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("did you mean warmth?"));
  EXPECT_FALSE(std::filesystem::exists(bench / "x.vtu"));
}

TEST(ImportCommand, cuts_curved_cells_more_finely_for_a_smaller_error_and_so_does_pack) {
  const Workbench bench;
  make_bent_vtk(bench);
  std::size_t before = 0;
  for (const char* error : {"0.2", "0.05", "0.01"}) {
    const RunResult run = bench.rhoray({"import", "bent.vtk", "-o", "x.vtu", "--force", "--max-error", error});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::size_t count = preprocess::import_mesh(bench / "x.vtu").cells.size();
    EXPECT_GT(count, before);
    before = count;
    const RunResult packed =
        bench.rhoray({"pack", "bent.vtk", "-o", "x.rho", "--force", "--max-error", error, "--json"});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
    const nlohmann::json description = nlohmann::json::parse(packed.out)["description"];
    EXPECT_THAT(description.dump(), HasSubstr(std::string("--max-error ") + error));
    std::string said = packed.err;
    std::erase(said, ',');
    EXPECT_THAT(said, HasSubstr(concat("became ", count, " tetrahedr")));
  }
}

TEST(ImportCommand, cuts_curved_cells_for_the_fields_that_are_kept_and_so_does_pack) {
  const Workbench bench;
  write_file(bench / "two.vtk",
             "# vtk DataFile Version 3.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 double\n"
             "0 0 0 1 0 0 0 1 0 0 0 1 0.5 0 0 0.5 0.5 0 0 0.5 0 0 0 0.5 0.5 0 0.5 0 0.5 0.5\n"
             "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n"
             "POINT_DATA 10\nSCALARS curved double\nLOOKUP_TABLE default\n0 1 0 0 0.9 0.2 0 0 0 0.7\n"
             "SCALARS linear double\nLOOKUP_TABLE default\n0 1 0 0 0.5 0.5 0 0 0.5 0\n");
  for (const char* verb : {"import two.vtk -o x.vtu", "pack two.vtk -o x.rho"}) {
    SCOPED_TRACE(verb);
    const RunResult all = bench.shell(concat("rhoray ", verb, " --force"));
    ASSERT_EQ(all.exit_code, 0) << all.err;
    EXPECT_THAT(all.err,
                HasSubstr("1 curved cell cut finer than the corners require: 100 % of the cuts for field \"curved\""));
    const RunResult one = bench.shell(concat("rhoray ", verb, " --force --field linear"));
    ASSERT_EQ(one.exit_code, 0) << one.err;
    EXPECT_THAT(one.err, HasSubstr("1 quadratic tetrahedron became 1 tetrahedron\n"));
  }
}

TEST(ImportCommand, refuses_what_makes_no_sense) {
  const Workbench bench;
  make_mixed_vtk(bench);
  bench.make_ball_raw();
  const auto refused = [&](const std::string& line, int exit_code, const std::string& words) {
    const RunResult run = bench.shell("rhoray " + line);
    EXPECT_EQ(run.exit_code, exit_code) << line;
    EXPECT_THAT(run.err, HasSubstr(words)) << line;
  };
  refused("import mixed.vtk", 2, "-o");
  refused("import mixed.vtk -o x.msh", 2, "expected .vtu");
  refused("import mixd.vtk -o x.vtu", 3, "did you mean mixed.vtk?");
  refused("import ball.raw -o x.vtu", 7, "is not a mesh of volume cells");
  refused("import mixed.vtk -o x.vtu --max-error 0", 2, "largest error");
  refused("import mixed.vtk -o x.vtu --time 3", 2, "no time steps");
  refused("pack mixed.vtk -o x.rho --time 3", 2, "no time steps");
  refused("pack ball.raw --raw 24x24x24:uint8 -o x.rho --max-error 0.1", 2, "--max-error: only for meshes");
}

}  // namespace
}  // namespace rhoray::tests
