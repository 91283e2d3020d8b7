// The studies of the cost of methods and data representations run on small data. Their tables must
// show what theory demands: errors that shrink, misses that vanish, nothing wrong where nothing can
// be wrong. Speed is not tested.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"
#include "tools/analysis/gnuplot.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;

void must_run(std::vector<std::string> words, const TemporaryFolder& folder) {
  const RunResult result = run_program(words, folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
}

/// Packs one of our recipes as NAME.rho.
void make_grid(const TemporaryFolder& folder, const std::string& recipe, const std::string& size) {
  must_run({RHORAY_RECIPES_PROGRAM, recipe, "-o", recipe + ".nhdr", "--size", size}, folder);
  must_run({RHORAY_PROGRAM, "pack", recipe + ".nhdr", "-o", recipe + ".rho", "-q"}, folder);
}

/// torso.rho, some 5,000 tetrahedra with the field 'potential'.
void make_torso(const TemporaryFolder& folder) {
  must_run({RHORAY_RECIPES_PROGRAM, "torso-surface", "-o", "torso.smesh", "--cells", "5000"}, folder);
  must_run({RHORAY_PROGRAM, "tetrahedralize", "torso.smesh", "-o", "mesh.vtu", "--quality", "1.4", "-q"}, folder);
  must_run({RHORAY_RECIPES_PROGRAM, "torso-potential", "mesh.vtu", "-o", "torso.vtu"}, folder);
  must_run({RHORAY_PROGRAM, "pack", "torso.vtu", "--field", "potential", "-o", "torso.rho", "-q"}, folder);
}

json table(const TemporaryFolder& folder, const std::string& name) {
  const std::string csv = read_file(folder / (name + ".csv"));
  json read = json::parse(read_file(folder / (name + ".json")));
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), read["rows"].size() + 1);
  EXPECT_TRUE(read["context"].contains("commit"));
  return read;
}

void expect_figure(const TemporaryFolder& folder, const std::string& name) {
  if (!tools::has_gnuplot()) {
    EXPECT_FALSE(std::filesystem::exists(folder / (name + ".svg")));
    return;
  }
  const std::string svg = read_file(folder / (name + ".svg"));
  EXPECT_NE(svg.find("</svg>"), std::string::npos) << name;
  EXPECT_LT(svg.size(), 100'000U) << name;  // small enough to be kept beside the tables
}

TEST(ResampleOrDirect, errs_less_on_finer_grids_and_not_at_all_in_the_tetrahedra) {
  const TemporaryFolder folder;
  make_torso(folder);
  must_run({RHORAY_LAB_PROGRAM, "resample-or-direct", "torso.rho", "--iso", "p75", "--grids", "12,24,48", "--whole",
            "24", "--vdb", "24", "--size", "64x64", "--repeat", "1", "-o", "."},
           folder);
  const json read = table(folder, "resample_or_direct");
  std::map<std::string, std::vector<json>> rows;
  for (const json& row : read["rows"]) rows[row["data"]].push_back(row);
  ASSERT_EQ(rows["tetrahedra"].size(), 3U);
  for (const json& row : rows["tetrahedra"]) {
    EXPECT_EQ(row["missed"], 0) << row;
    EXPECT_EQ(row["false_hits"], 0) << row;
    // Single precision is the coarsest level; the surface in linear cells is found by one division.
    EXPECT_LT(row["depth_p99_cells"], 1e-3) << row;
    EXPECT_EQ(row["resample_cpu_s"], 0) << row;
  }
  const std::vector<json>& grids = rows["grid, bricks of the mesh"];
  ASSERT_EQ(grids.size(), 3U);
  for (std::size_t g = 1; g < grids.size(); ++g) {
    EXPECT_LT(grids[g]["depth_median_cells"], grids[g - 1]["depth_median_cells"]);
    EXPECT_LT(grids[g]["rmse_of_255"], grids[g - 1]["rmse_of_255"]);
    EXPECT_LT(grids[g]["step_in_cells"], grids[g - 1]["step_in_cells"]);
    EXPECT_GT(grids[g]["bytes"], grids[g - 1]["bytes"]);
  }
  // The three hold the same samples: their pictures differ only by the default method of each.
  for (const char* kind : {"grid, whole box", "OpenVDB"}) {
    ASSERT_EQ(rows[kind].size(), 1U);
    const json &other = rows[kind][0], &same = grids[1];
    EXPECT_NEAR(other["depth_median_cells"], same["depth_median_cells"], 1e-3) << kind;
    EXPECT_NEAR(other["missed"], same["missed"], 4) << kind;
  }
  expect_figure(folder, "resample_or_direct_error");
  expect_figure(folder, "resample_or_direct_time");
}

TEST(Bits, errs_more_with_every_bit_less) {
  const TemporaryFolder folder;
  make_grid(folder, "marschner-lobb", "24");
  must_run(
      {RHORAY_LAB_PROGRAM, "bits", "marschner-lobb.rho", "--iso", "0.5", "--size", "64x64", "--repeat", "1", "-o", "."},
      folder);
  const json read = table(folder, "bits");
  std::map<std::string, json> rows;  // at the level double
  for (const json& row : read["rows"])
    if (row["level"] == "double") rows[row["stored"]] = row;
  ASSERT_EQ(rows.size(), 6U) << "float as it is, half, 16, 12, 10 and 8 bits; double and float again lose nothing";
  const json& as_is = rows["as it is, F32"];
  EXPECT_EQ(as_is["missed"], 0);
  EXPECT_EQ(as_is["false_hits"], 0);
  EXPECT_LT(as_is["depth_max_cells"], 1e-6);
  const char* const fewer[] = {"16 bits", "12 bits", "10 bits", "8 bits"};
  for (std::size_t i = 1; i < std::size(fewer); ++i)
    for (const char* column : {"depth_median_cells", "value_p99_of_range", "normal_p99_deg"})
      EXPECT_LT(rows[fewer[i - 1]][column], rows[fewer[i]][column]) << fewer[i] << " " << column;
  // Rounding to 2^-n of the range moves a value by at most half of that.
  for (const char* name : fewer)
    EXPECT_LE(rows[name]["value_max_of_range"], 0.5001 / (std::exp2(int{rows[name]["bits"]}) - 1)) << name;
  // A half has 11 significant bits. Near half of the range 0 to 1, it resolves as much as 11 or 12
  // bits of the range.
  EXPECT_LT(rows["half"]["depth_median_cells"], rows["10 bits"]["depth_median_cells"]);
  EXPECT_GT(rows["half"]["depth_median_cells"], rows["16 bits"]["depth_median_cells"]);
  expect_figure(folder, "bits_depth");
  expect_figure(folder, "bits_normal");
}

/// Checks what holds for any data: rays that know their side are right; among moved rays, more leak
/// the farther they are moved.
void expect_sane_starts(const json& read) {
  const auto wrong = [&](const std::string& start, const std::string& hits, double epsilon, const char* column) {
    for (const json& row : read["rows"])
      if (row["start"] == start && row["hits"] == hits &&
          (epsilon == 0 ? row["epsilon_cells"].is_null() : row["epsilon_cells"] == epsilon))
        return int{row[column]};
    ADD_FAILURE() << start << ", " << hits << ", " << epsilon;
    return -1;
  };
  const int rays = wrong("knows its side", "double", 0, "rays"), dark = wrong("knows its side", "double", 0, "dark");
  EXPECT_GT(rays, 200);
  EXPECT_GT(dark, 10);
  EXPECT_LT(dark, rays);
  EXPECT_EQ(wrong("knows its side", "double", 0, "acne"), 0);
  EXPECT_EQ(wrong("knows its side", "double", 0, "leaks"), 0);
  for (const char* start : {"moved along the ray", "moved along the normal"}) {
    // An epsilon far below the rounding of the hits moves nothing: about half of the positions lie
    // behind the surface.
    EXPECT_GT(wrong(start, "float", 1e-9, "acne"), rays / 10) << start;
    EXPECT_GE(wrong(start, "float", 1, "leaks"), wrong(start, "float", 0.01, "leaks")) << start;
    EXPECT_LE(wrong(start, "double", 1e-3, "acne"), wrong(start, "float", 1e-7, "acne")) << start;
  }
}

TEST(Epsilon, finds_acne_where_it_is_too_small_and_leaks_where_it_is_too_large) {
  const TemporaryFolder folder;
  make_grid(folder, "smooth", "32");
  must_run({RHORAY_LAB_PROGRAM, "epsilon", "smooth.rho", "--iso", "2200.5", "--size", "64x64", "-o", "."}, folder);
  expect_sane_starts(table(folder, "epsilon_shadows"));
  const json steps = table(folder, "epsilon_steps");
  std::map<double, int> wrong;
  for (const json& row : steps["rows"]) {
    if (row["refinement"] == "linear") wrong[row["step_cells"]] = int{row["missed"]} + int{row["false_hits"]};
    if (row["method"] == "double") {
      EXPECT_EQ(row["missed"], 0);
      EXPECT_EQ(row["false_hits"], 0);
    }
  }
  ASSERT_EQ(wrong.size(), 8U);
  EXPECT_LT(wrong[0.015625], wrong[2]);
  EXPECT_GT(wrong[2], 0);
  expect_figure(folder, "epsilon_shadows");
  expect_figure(folder, "epsilon_steps");
}

TEST(Epsilon, says_the_same_of_tetrahedra) {
  const TemporaryFolder folder;
  make_torso(folder);
  must_run({RHORAY_LAB_PROGRAM, "epsilon", "torso.rho", "--iso", "p75", "--size", "48x48", "--light", "0.2,-0.3,1",
            "-o", "."},
           folder);
  expect_sane_starts(table(folder, "epsilon_shadows"));
}

TEST(Extraction, times_the_surface_mesher_when_it_is_asked_for) {
  const TemporaryFolder folder;
  make_grid(folder, "smooth", "24");
  must_run({RHORAY_LAB_PROGRAM, "extraction", "smooth.rho", "--iso", "600.5", "--size", "32x32", "--repeat", "1",
            "--cgal", "500", "-o", "."},
           folder);
  const json read = table(folder, "extraction");
  ASSERT_EQ(read["rows"].size(), 6U);
  const json& cgal = read["rows"][3];
  EXPECT_TRUE(std::string(cgal["system"]).starts_with("CGAL's surface mesher")) << cgal;
  EXPECT_GT(cgal["triangles"], 100);
  EXPECT_LT(cgal["triangles"], 5000);
}

TEST(Conclusions, are_not_drawn_from_requests_without_sense) {
  const TemporaryFolder folder;
  make_grid(folder, "smooth", "16");
  for (const auto& [words, code] :
       std::vector<std::pair<std::vector<std::string>, int>>{{{"resample-or-direct", "smooth.rho"}, 2},
                                                             {{"resample-or-direct", "none.rho"}, 3},
                                                             {{"resample-or-direct", "smooth.rho", "--grids", "1"}, 2},
                                                             {{"bits", "smooth.rho", "--levels", "high"}, 2},
                                                             {{"bits", "smooth.rho", "-o", "nowhere"}, 2},
                                                             {{"bits", "smooth.rho", "--repeat", "0"}, 2},
                                                             {{"epsilon", "smooth.rho", "--light", "0,0,0"}, 2},
                                                             {{"epsilon", "smooth.rho", "--iso", "1e9"}, 2},
                                                             {{"epsilon", "smooth.rho", "-o", "nowhere"}, 2},
                                                             {{"extraction", "smooth.rho", "--cgal", "1"}, 2}}) {
    std::vector<std::string> line{RHORAY_LAB_PROGRAM};
    line.insert(line.end(), words.begin(), words.end());
    const RunResult result = run_program(line, folder.path());
    EXPECT_EQ(result.exit_code, code) << testing::PrintToString(words) << result.err;
    EXPECT_NE(result.err, "");
    EXPECT_EQ(result.out, "") << "no work was done for nothing";
  }
}

}  // namespace
}  // namespace rhoray::tests
