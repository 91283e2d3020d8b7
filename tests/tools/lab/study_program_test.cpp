// The comparison studies with other systems run, and their results are sane. Speed is not tested.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;

void must_run(std::vector<std::string> words, const TemporaryFolder& folder) {
  const RunResult result = run_program(words, folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
}

/// smooth.rho, 32^3.
void make_grid(const TemporaryFolder& folder) {
  must_run({RHORAY_RECIPES_PROGRAM, "smooth", "-o", "smooth.nhdr", "--size", "32"}, folder);
  must_run({RHORAY_PROGRAM, "pack", "smooth.nhdr", "-o", "smooth.rho", "-q"}, folder);
}

json table(const TemporaryFolder& folder, const std::string& name) {
  const std::string csv = read_file(folder / (name + ".csv"));
  json read = json::parse(read_file(folder / (name + ".json")));
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), read["rows"].size() + 1);
  return read;
}

TEST(StudyProgram, shows_every_system_that_is_there_beside_the_exact_answer) {
  const TemporaryFolder folder;
  make_grid(folder);
  must_run({RHORAY_LAB_PROGRAM, "peers-grid", "smooth.rho", "--iso", "600.5", "--mip", "--views", "front,inside",
            "--size", "48x40", "--repeat", "1", "-o", "."},
           folder);
  const json surface = table(folder, "peers_isosurface");
  std::map<std::string, int> seen;
  for (const json& row : surface["rows"]) {
    const std::string system = row["system"], where = system + ", " + std::string(row["view"]);
    ++seen[system];
    EXPECT_GT(row["cpu_ms"], 0.0) << where;
    EXPECT_GT(row["hits"], 100) << where;
    EXPECT_EQ(row["picture"].is_string(), system.starts_with("Rhoray")) << where;
    const bool is_proven = system == "Rhoray, exact" || system == "Rhoray, certified" || system == "Rhoray, double";
    EXPECT_LE(row["missed"], is_proven ? 0 : 30) << where;
    EXPECT_LE(row["false"], is_proven ? 0 : 60) << where;
    const double median = row["error_median_voxels"];
    EXPECT_LT(median, is_proven ? 1e-6 : system.starts_with("NanoVDB") ? 2.0 : 0.2) << where;
    if (system == "Rhoray, float") {
      EXPECT_EQ(row["over_ours"], 1);
    }
  }
  for (const char* system : {"Rhoray, preview", "Rhoray, float", "Rhoray, double", "Rhoray, certified", "Rhoray, exact",
                             "NanoVDB, dense", "NanoVDB, narrow", "OpenVDB, level set"})
    EXPECT_EQ(seen[system], 2) << system;
  // Other systems are included, or the reason for their absence is given.
  const json& left_out = surface["context"]["left_out"];
  EXPECT_EQ(seen["Embree, packets"], left_out.contains("Embree") ? 0 : 2);
  EXPECT_EQ(seen["Embree, single rays"], left_out.contains("Embree") ? 0 : 2);
  EXPECT_EQ(seen["VTK, drawing"], left_out.contains("VTK, drawing") ? 0 : 2);

  const json largest = table(folder, "peers_mip");
  seen.clear();
  for (const json& row : largest["rows"]) {
    const std::string system = row["system"];
    ++seen[system];
    EXPECT_LT(row["error_mean_levels"], system.starts_with("Rhoray") ? 1e-5 : 10.0) << system;
  }
  EXPECT_EQ(seen["Rhoray, double"], 2);
  const bool has_vtk = !largest["context"]["left_out"].contains("VTK, largest values");
  for (const char* system : {"VTK, step 1", "VTK, step 0.5", "VTK, step 0.1"}) EXPECT_EQ(seen[system], has_vtk ? 2 : 0);
}

TEST(StudyProgram, shows_the_same_picture_with_every_layout) {
  const TemporaryFolder folder;
  make_grid(folder);
  must_run({RHORAY_LAB_PROGRAM, "layouts", "smooth.rho", "--iso", "600.5", "--views", "front,close-up", "--size",
            "40x40", "--repeat", "1", "-o", "."},
           folder);
  const json layouts = table(folder, "layouts");
  ASSERT_EQ(layouts["rows"].size(), 26U);
  std::map<std::string, std::string> picture;
  for (const json& row : layouts["rows"]) {
    const std::string layout = row["layout"], view = row["view"];
    if (layout == "initial") {
      picture[view] = row["picture"];
      EXPECT_EQ(row["macrocells_per_ray"], 0.0);
    }
    if (layout == "8 bit") {
      EXPECT_NE(row["picture"], picture[view]);
    } else {
      EXPECT_EQ(row["picture"], picture[view]) << layout;  // bit-identical in double precision
      EXPECT_EQ(row["other_pixels"], 0.0) << layout;
    }
    EXPECT_GT(row["cpu_ms"], 0.0);
    EXPECT_GT(row["cells_per_ray"], 0.0);
  }
  EXPECT_EQ(picture.size(), 2U);
}

TEST(StudyProgram, asks_every_structure_of_a_mesh_the_same_rays) {
  const TemporaryFolder folder;
  must_run({RHORAY_LAB_PROGRAM, "structures", "--cells", "400", "--size", "32x32", "--repeat", "1", "-o", "."}, folder);
  for (const auto& [name, rows_of_a_mesh] :
       {std::pair("structures", 12U), std::pair("structures_orders", 19U), std::pair("structures_points", 5U)}) {
    const json read = table(folder, name);
    // Meshes: even, graded in three ways, slivers.
    ASSERT_EQ(read["rows"].size(), 5 * rows_of_a_mesh) << name;
    std::map<std::string, json> answers;
    for (const json& row : read["rows"]) {
      EXPECT_GT(row["cpu_us_per_ray"], 0.0) << row;
      if (row.contains("answers")) {
        EXPECT_EQ(answers.try_emplace(row["mesh"], row["answers"]).first->second, row["answers"]) << row;
        EXPECT_GT(row["tested_per_ray"], 0.0) << row;
      } else if (row["points"] == "doubles") {
        EXPECT_EQ(row["off_largest_edges"], 0.0) << row;
      } else {
        EXPECT_GT(row["off_mean_edges"], 0.0) << row;
      }
    }
  }
}

TEST(StudyProgram, refuses_requests_without_sense) {
  const TemporaryFolder folder;
  make_grid(folder);
  for (const auto& [words, code] :
       std::vector<std::pair<std::vector<std::string>, int>>{{{"peers-grid", "smooth.rho", "--systems", "osprey"}, 2},
                                                             {{"peers-grid", "smooth.rho", "--views", "back"}, 2},
                                                             {{"peers-grid", "smooth.rho", "--repeat", "0"}, 2},
                                                             {{"peers-grid", "none.rho"}, 3},
                                                             {{"layouts", "smooth.rho", "--accuracy", "high"}, 2},
                                                             {{"layouts", "smooth.rho", "-o", "nowhere"}, 2},
                                                             {{"peers-grid", "smooth.rho", "-o", "nowhere"}, 2},
                                                             {{"maximum-search", "smooth.rho", "-o", "nowhere"}, 2},
                                                             {{"judge-cells", "-o", "nowhere"}, 2},
                                                             {{"closed-surfaces", "-o", "nowhere"}, 2},
                                                             {{"largest-values", "-o", "nowhere"}, 2},
                                                             {{"preprocess-speed", "-o", "nowhere"}, 2},
                                                             {{"structures", "-o", "nowhere"}, 2},
                                                             {{"structures", "--cells", "1"}, 2},
                                                             {{"layouts", "smooth.raw"}, 4}}) {
    std::vector<std::string> line{RHORAY_LAB_PROGRAM};
    line.insert(line.end(), words.begin(), words.end());
    const RunResult result = run_program(line, folder.path());
    EXPECT_EQ(result.exit_code, code) << testing::PrintToString(words) << result.err;
    EXPECT_NE(result.err, "");
    EXPECT_EQ(result.out, "") << "no work was done for nothing";
  }
}

TEST(StudyProgram, sets_triangles_beside_direct_drawing) {
  const TemporaryFolder folder;
  make_grid(folder);
  must_run({RHORAY_LAB_PROGRAM, "extraction", "smooth.rho", "--iso", "600.5", "--size", "48x40", "-o", "."}, folder);
  const json read = table(folder, "extraction");
  ASSERT_EQ(read["rows"].size(), 5U);
  for (const json& row : read["rows"]) {
    const bool is_own = std::string(row["system"]).starts_with("Rhoray");
    EXPECT_EQ(row["triangles"].is_null(), is_own) << row;
    if (!is_own) {
      // All three divide the same cells in such similar ways that they make nearly the same number
      // of triangles.
      const double triangles = row["triangles"];
      EXPECT_NEAR(triangles, read["rows"][0]["triangles"], 0.1 * triangles);
      EXPECT_GT(row["extraction_ms"], 0.0);
    }
  }
}

}  // namespace
}  // namespace rhoray::tests
