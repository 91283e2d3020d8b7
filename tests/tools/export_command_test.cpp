#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(ExportCommand, writes_every_format_and_reports_it) {
  const Workbench bench;
  bench.make_ball();
  for (const std::string extension : {"vti", "vdb", "nvdb", "npy", "nii", "stl"}) {
    SCOPED_TRACE(extension);
    std::vector<std::string> words{"export", "ball.rho", "-o", "out." + extension, "--json"};
    if (extension == "stl") words.insert(words.end(), {"--iso", "128"});
    const RunResult run = bench.rhoray(words);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json report = json::parse(run.out);
    EXPECT_EQ(report["file_bytes"].get<std::uintmax_t>(), std::filesystem::file_size(bench / ("out." + extension)));
    EXPECT_EQ(report.contains("triangles"), extension == "stl");
    const RunResult again = bench.rhoray(words);
    EXPECT_EQ(again.exit_code, 2);
    words.push_back("--force");
    EXPECT_EQ(bench.rhoray(words).exit_code, 0);
  }
  bench.make_box();
  for (const std::string name : {"out.vtu", "own.stl"})
    EXPECT_EQ(bench.rhoray({"export", "box.rho", "-o", name, "-q"}).exit_code, 0);
  EXPECT_EQ(bench.contents().size(), 12U);
}

TEST(ExportCommand, gives_back_the_samples_that_were_packed) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(bench.rhoray({"export", "ball.rho", "-o", "back.npy", "-q"}).exit_code, 0);
  const std::string back = read_file(bench / "back.npy"), raw = read_file(bench / "ball.raw");
  EXPECT_EQ(back.substr(back.size() - raw.size()), raw);
  ASSERT_EQ(bench.rhoray({"export", "ball.rho", "-o", "back.vti", "-q"}).exit_code, 0);
  ASSERT_EQ(bench.rhoray({"pack", "back.vti", "-o", "again.rho", "-q"}).exit_code, 0);
  ASSERT_EQ(bench.rhoray({"export", "again.rho", "-o", "again.npy", "-q"}).exit_code, 0);
  EXPECT_EQ(read_file(bench / "again.npy"), back);
}

TEST(ExportCommand, refuses_what_a_format_cannot_hold_and_says_what_can) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  struct Row {
    std::vector<std::string> words;
    int exit_code;
    std::string said;
  };
  const Row rows[] = {{{"box.rho", "-o", "x.npy"}, 7, "formats/SPEC.md"},
                      {{"box.rho", "-o", "x.vdb"}, 7, "holds grids"},
                      {{"ball.rho", "-o", "x.vtu"}, 7, ".vti"},
                      {{"ball.rho", "-o", "x.stl"}, 2, "--iso"},
                      {{"ball.rho", "-o", "x.vti", "--iso", "3"}, 2, "only for .stl"},
                      {{"ball.rho", "-o", "x.stl", "--iso", "300"}, 2, "outside the range"},
                      {{"ball.rho", "-o", "x.vtt"}, 2, "did you mean .vt"},
                      {{"ball.rho"}, 2, "-o: missing"},
                      {{"ball.raw", "-o", "x.vti"}, 7, "unsupported file type"},
                      {{"none.rho", "-o", "x.vti"}, 3, "no such file"},
                      {{"box.rho", "-o", "x.stl", "--iso", "0.5", "--field", "hight"}, 2, "did you mean height"}};
  const auto before = bench.contents();
  for (const Row& row : rows) {
    std::vector<std::string> words{"export"};
    words.insert(words.end(), row.words.begin(), row.words.end());
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, row.exit_code) << run.err;
    EXPECT_THAT(run.err, HasSubstr(row.said));
  }
  EXPECT_EQ(bench.contents(), before);
}

TEST(ExportCommand, names_the_remedy_for_a_field_of_cells_as_measure_does) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  mesh.cell_fields.push_back({.name = "load", .unit = {}, .values = {}});
  for (const auto& cell : mesh.cells) mesh.cell_fields[0].values.push_back(mesh.points[cell[0]][2]);
  preprocess::export_mesh(mesh, bench / "cells.vtu", false);
  ASSERT_EQ(bench.rhoray({"pack", "cells.vtu", "-q"}).exit_code, 0);
  for (const std::string words : {"measure FILE --field load", "export FILE --iso 0.5 --field load -o x.stl --force"}) {
    const auto run_on = [&](const std::string& file) {
      return bench.shell("rhoray " + std::string(words).replace(words.find("FILE"), 4, file));
    };
    const RunResult refused = run_on("cells.rho");
    EXPECT_EQ(refused.exit_code, 2) << words;
    EXPECT_THAT(refused.err, HasSubstr("no field 'load'"));
    EXPECT_THAT(refused.err, HasSubstr("hint: it is a field of cells; `rhoray pack --cell-data`"));
    ASSERT_EQ(bench.rhoray({"pack", "cells.vtu", "--cell-data", "-o", "points.rho", "--force", "-q"}).exit_code, 0);
    const RunResult remedied = run_on("points.rho");
    EXPECT_EQ(remedied.exit_code, 0) << remedied.err;
  }
}

TEST(ExportCommand, names_the_file_that_a_limit_of_size_stops) {
  const Workbench bench;
  bench.make_box();
  bench.make_ball();
  for (const std::string line : {"box.rho -o limited.vtu", "ball.rho -o limited.vti"}) {
    const RunResult run = bench.shell("ulimit -f 8; rhoray export " + line);
    EXPECT_EQ(run.exit_code, 5);
    EXPECT_THAT(run.err, HasSubstr("limited.vt"));
    EXPECT_THAT(run.err, testing::Not(HasSubstr("descriptor")));
  }
}

TEST(VdbFiles, are_packed_drawn_and_described_like_their_packed_copy) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(bench.rhoray({"export", "ball.rho", "-o", "ball.vdb", "-q"}).exit_code, 0);
  const std::vector<std::string> look{
      "--iso",    "100",         "--size", "64x64", "--camera-position", "40,-60,30", "--camera-target",
      "12,12,12", "--camera-up", "0,0,1",  "--json"};
  const auto hits = [&](const std::string& file) {
    std::vector<std::string> words{"render", file, "-o", file + ".png", "--force"};
    words.insert(words.end(), look.begin(), look.end());
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out)["statistics"]["hits"].get<int>();
  };
  EXPECT_GT(hits("ball.rho"), 100);
  EXPECT_EQ(hits("ball.vdb"), hits("ball.rho"));
  EXPECT_EQ(bench.rhoray({"render", "ball.vdb", "--mode", "mip", "-o", "mip.png", "-q", "--size", "32x32"}).exit_code,
            0);
  const json info = json::parse(bench.rhoray({"info", "ball.vdb", "--json"}).out);
  EXPECT_EQ(info["kind"], "vdb");
  EXPECT_EQ(info["grids"][0]["active_voxels"], 24 * 24 * 24);
  const json packed = json::parse(bench.rhoray({"info", "ball.rho", "--json"}).out);
  EXPECT_EQ(info["fields"][0]["range"], packed["fields"][0]["range"]);
  EXPECT_THAT(bench.rhoray({"info", "ball.vdb"}).out, HasSubstr("13,824 active voxels in (0 0 0) to (23 23 23)"));
  ASSERT_EQ(bench.rhoray({"pack", "ball.vdb", "-o", "copy.rho", "-q"}).exit_code, 0);
  EXPECT_EQ(hits("copy.rho"), hits("ball.rho"));
}

}  // namespace
}  // namespace rhoray::tests
