#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

TEST(ResampleCommand, makes_a_sound_grid_that_can_be_rendered) {
  const Workbench bench;
  bench.make_box_vtu();
  const RunResult result = bench.rhoray({"resample", "box.vtu", "--size", "20", "--field", "length,height", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("box_grid.rho: 20 x 20 x 20 samples, 8,000 in the mesh and 0 outside"));
  EXPECT_THAT(result.err, HasSubstr("error of length: at most "));
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["inside_count"], 8000);
  EXPECT_EQ(json["errors"][0]["field"], "length");
  EXPECT_GT(json["errors"][0]["max_error"], 0.001);
  EXPECT_LT(json["errors"][0]["max_error"], 0.1);
  EXPECT_LT(json["errors"][1]["max_error"], 1e-5) << "height is linear";
  EXPECT_EQ(json["file_bytes"], std::filesystem::file_size(bench / "box_grid.rho"));
  EXPECT_EQ(bench.rhoray({"verify", "--deep", "box_grid.rho"}).exit_code, 0);
  EXPECT_EQ(bench.rhoray({"render", "box_grid.rho", "--iso", "0.8", "--size", "40x30", "-o", "x.png"}).exit_code, 0);
}

TEST(ResampleCommand, takes_packed_tetrahedra_as_it_takes_their_source) {
  const Workbench bench;
  bench.make_box();
  for (const char* input : {"box.vtu", "box.rho"}) {
    const RunResult result =
        bench.rhoray({"resample", input, "--spacing", "0.125,0.25,0.5", "-o", "grid.rho", "--force", "--json"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["inside_count"], 9 * 5 * 3) << input;
  }
}

TEST(ResampleCommand, refines_to_the_error_that_is_asked_for) {
  const Workbench bench;
  bench.make_box_vtu();
  const RunResult result =
      bench.rhoray({"resample", "box.vtu", "--max-error", "1%", "--field", "length", "--json", "-v"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_LE(json["errors"][0]["max_error"], 0.01 * std::sqrt(3.0));
  EXPECT_EQ(json["attempts"].back()["max_error"], json["errors"][0]["max_error"]);
}

TEST(ResampleCommand, keeps_a_grid_that_misses_the_error_and_exits_with_6) {
  const Workbench bench;
  bench.make_box();
  for (const char* output : {"grid.rho", "grid.vdb"}) {
    const RunResult result = bench.rhoray({"resample", "box.rho", "--max-error", "0.0001%", "--field", "length",
                                           "--memory", "8M", "--size", "40", "-o", output, "--json"});
    EXPECT_EQ(result.exit_code, 6) << output << "\n" << result.err;
    EXPECT_THAT(result.err, HasSubstr("was requested"));
    EXPECT_THAT(result.err, HasSubstr("hint: the file was written"));
    EXPECT_LT(result.err.find("coverage of length: 100 %"), result.err.find("error of length: at most"));
    const nlohmann::json json = nlohmann::json::parse(result.out);
    EXPECT_FALSE(json["reached"]);
    EXPECT_EQ(json["coverage"], 1.0);
    EXPECT_TRUE(std::filesystem::exists(bench / output));
  }
  EXPECT_EQ(bench.rhoray({"verify", "--deep", "grid.rho"}).exit_code, 0);
  EXPECT_THAT(bench.rhoray({"info", "grid.rho"}).out, HasSubstr("not reached"));
  const nlohmann::json info = nlohmann::json::parse(bench.rhoray({"info", "grid.rho", "--json"}).out);
  EXPECT_FALSE(info["fields"][0]["certificate"]["meets_request"]);
  EXPECT_EQ(info["fields"][0]["certificate"]["coverage"], 1.0);
}

TEST(ResampleCommand, counts_only_the_part_of_the_mesh_with_data) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "length", [](const Vec3& p) { return p.length(); });
  mesh.point_fields[0].values[0] = std::numeric_limits<double>::quiet_NaN();
  preprocess::export_mesh(mesh, bench / "holed.vtu", false);
  const RunResult result = bench.rhoray({"resample", "holed.vtu", "--size", "9", "-o", "grid.rho"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("note: field \"length\" has no data at 1 point; adjacent cells"));
  EXPECT_THAT(result.err,
              HasSubstr("coverage of length: 100 % of the mesh's volume where it has data lies in grid cells"));
  const RunResult missed = bench.rhoray(
      {"resample", "holed.vtu", "--max-error", "0.0001%", "--memory", "8M", "--size", "40", "-o", "x.rho"});
  EXPECT_EQ(missed.exit_code, 6) << missed.err;
  EXPECT_THAT(missed.err, HasSubstr(" % of the mesh where it has data; "));
}

TEST(ResampleCommand, writes_openvdb_with_the_same_samples) {
  const Workbench bench;
  bench.make_box_vtu();
  const RunResult result = bench.shell("rhoray resample box.vtu --size 9 --field length -o box.vdb");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("error of length: at most"));
  ASSERT_EQ(bench.shell("rhoray resample box.vtu --size 9 --field length -o box_grid.rho").exit_code, 0);
  ASSERT_EQ(bench.shell("rhoray pack box.vdb -o again.rho").exit_code, 0);
  const auto field_of = [&](const char* file) {
    return nlohmann::json::parse(bench.rhoray({"info", file, "--json"}).out)["fields"][0];
  };
  const nlohmann::json direct = field_of("box_grid.rho"), again = field_of("again.rho");
  for (int end = 0; end < 2; ++end)  // OpenVDB holds single precision
    EXPECT_NEAR(direct["range"][end].get<double>(), again["range"][end].get<double>(), 1e-6);
  // No other files are left.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(bench / ""), {}), 4);
}

TEST(ResampleCommand, refuses_in_one_sentence) {
  const Workbench bench;
  bench.make_box_vtu();
  bench.make_ball();
  struct Case {
    const char* line;
    int exit_code;
    const char* words;
  };
  const Case cases[] = {
      {"rhoray resample box.vtu", 2, "no resolution given"},
      {"rhoray resample box.vtu --size 9 --spacing 1", 2, "mutually exclusive"},
      {"rhoray resample box.vtu --size 9x9", 2, "expected N or NxNxN"},
      {"rhoray resample box.vtu --size 1", 2, "expected 2 to 1048576"},
      {"rhoray resample box.vtu --size 0", 2, "found 0"},
      {"rhoray resample box.vtu --spacing -1", 2, "found -1"},
      {"rhoray resample box.vtu --max-error 0", 2, "found 0"},
      {"rhoray resample box.vtu --size 9 --field hight", 2, "height"},
      {"rhoray resample box.vtu --size 9 -o x.png", 2, "expected .rho"},
      {"rhoray resample ball.rho --size 9 -o x.rho", 7, "is already a packed grid"},
      {"rhoray resample none.vtu --size 9", 3, "no such file"},
      {"rhoray resample box.vtu --size 2000 --memory 64M", 5, "2000 x 2000 x 2000 samples need"},
  };
  for (const Case& c : cases) {
    const RunResult result = bench.shell(c.line);
    EXPECT_EQ(result.exit_code, c.exit_code) << c.line << "\n" << result.err;
    EXPECT_THAT(result.err, HasSubstr(c.words)) << c.line;
  }
  EXPECT_FALSE(std::filesystem::exists(bench / "box_grid.rho"));
}

}  // namespace
}  // namespace rhoray::tests
