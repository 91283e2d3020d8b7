#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/made_grid.h"
#include "tests/support/narrowed.h"
#include "tests/support/packed_samples.h"
#include "tests/tools/workbench.h"

// A file whose stored ranges are too narrow, sealed again. Its checksums are right and opening it
// finds nothing, but cells that hold the surface are skipped. --verify once compared such a picture
// with itself and found nothing.

namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

struct Kind {
  std::string name;
  std::string file;
  std::vector<std::pair<std::string, IntervalStep>> arrays;
};

float distance(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<float>((Vec3(Index3(i, j, k)) - Vec3(10, 9, 8)).length());
}

std::vector<Kind> kinds(const Workbench& bench) {
  using enum IntervalStep;
  const std::vector<std::pair<std::string, IntervalStep>> levels{
      {"macro.1", macro_levels}, {"macro.2", macro_levels}, {"macro.3", macro_levels}};
  MadeGridChoice choice{.sample_count = {21, 19, 17}, .macro = {.factor = 4, .level_count = 3}};
  MadeGridChoice sparse = choice, rectilinear = choice;
  sparse.is_sparse = true;
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < choice.sample_count[axis]; ++i)
      rectilinear.axes[static_cast<std::size_t>(axis)].push_back(static_cast<double>(i) +
                                                                 0.02 * static_cast<double>(i * i));
  const auto outer = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i < 5 ? std::numeric_limits<float>::quiet_NaN() : distance(i, j, k);
  };
  const TetSample mesh =
      sample_tets(4, {{"distance", [](const Vec3& p) { return (p - Vec3(0.5, 0.5, 0.5)).length(); }}}, {6, 6, 6},
                  {1, 1, 1}, {.factor = 4, .level_count = 2});
  packed(mesh, bench / "lists.rho");
  packed(clustered(mesh, 8), bench / "clusters.rho");
  return {{"dense", made_grid(choice, {{"distance", distance}}).file(), levels},
          {"sparse", made_grid(sparse, {{"distance", outer}}).file(), levels},
          {"rectilinear", made_grid(rectilinear, {{"distance", distance}}).file(), levels},
          {"leaf lists",
           read_file(bench / "lists.rho"),
           {{"range.0.0", macro_levels}, {"range.0.1", macro_levels}, {"range.0.2", macro_levels}}},
          {"clusters",
           read_file(bench / "clusters.rho"),
           {{"range.0.0", cluster_ranges},
            {"range.0.1", cluster_ranges},
            {"cluster.boxes.0", cluster_boxes},
            {"cluster.boxes.1", cluster_boxes}}}};
}

const std::vector<std::string> proving_commands{
    "rhoray render x.rho --iso p30 --size 64x48 --verify 100 -o out",
    "rhoray render x.rho --iso p30 --size 64x48 --accuracy certified -o out",
    "rhoray render x.rho --iso p30 --size 64x48 --accuracy exact -o out",
    "rhoray render x.rho --mode mip --size 64x48 --accuracy certified -o out",
    "rhoray render x.rho --iso p30 --size 64x48 --max-error 0.1 -o out",
    "rhoray accuracy x.rho --iso p30 --size 64x48 --time-limit 1 -o out",
    "rhoray validate x.rho --iso p30 --samples 100 --report out"};

/// Runs the command, which writes "out"; a picture needs a file extension.
RunResult run(const Workbench& bench, std::string command) {
  if (command.starts_with("rhoray render")) command += ".png";
  return bench.shell(command);
}

/// The files, without empty report folders.
std::map<std::string, std::string> files_of(const Workbench& bench) {
  auto files = bench.contents();
  std::erase_if(files, [](const auto& entry) { return entry.second == "folder"; });
  return files;
}

TEST(StoredRanges, are_proven_before_anything_is_certified) {
  const Workbench bench;
  for (const Kind& kind : kinds(bench))
    for (const auto& [array, step] : kind.arrays) {
      SCOPED_TRACE(kind.name + ", " + array);
      write_file(bench / "x.rho", narrowed(kind.file, array, step));
      ASSERT_EQ(bench.shell("rhoray verify x.rho").exit_code, 0) << "checksums are right";
      const RunResult deep = bench.shell("rhoray verify --deep x.rho");
      EXPECT_EQ(deep.exit_code, 4);
      const auto before = files_of(bench);
      for (const std::string& command : proving_commands) {
        const RunResult refused = run(bench, command);
        EXPECT_EQ(refused.exit_code, 4) << command << "\n" << refused.out << refused.err;
        EXPECT_EQ(refused.out, "") << command;
        EXPECT_THAT(refused.err,
                    testing::MatchesRegex("(isovalue [^\n]*\n)?[^\n]*x\\.rho: [^\n]* has [^\n]*\n[^\n]*hint: [^\n]*\n"))
            << command;
        EXPECT_TRUE(files_of(bench) == before) << command << " left something behind";
      }
      const RunResult plain = bench.shell("rhoray render x.rho --iso p30 --size 64x48 --json --force -o plain.png");
      EXPECT_EQ(plain.exit_code, 0) << plain.err;
      EXPECT_EQ(json::parse(plain.out)["statistics"]["range_proof"]["bytes"], 0);
      std::filesystem::remove(bench / "plain.png");
    }
}

TEST(StoredRanges, of_sound_files_are_proven_and_the_cost_is_told) {
  const Workbench bench;
  for (const Kind& kind : kinds(bench)) {
    SCOPED_TRACE(kind.name);
    write_file(bench / "x.rho", kind.file);
    for (const char* words :
         {"--iso p30 --verify 100", "--iso p30 --accuracy certified", "--mode mip --accuracy exact"}) {
      const std::string line = concat("rhoray render x.rho --size 24x18 --force -o x.png ", words);
      const RunResult drawn = bench.shell(line + " --json");
      ASSERT_EQ(drawn.exit_code, 0) << words << drawn.err;
      const json proof = json::parse(drawn.out)["statistics"]["range_proof"];
      EXPECT_GT(proof["bytes"], kind.file.size() / 4);
      EXPECT_GT(proof["wall_s"], 0);
      EXPECT_NEAR(proof["s_per_gib"].get<double>(),
                  proof["wall_s"].get<double>() * 0x1p30 / proof["bytes"].get<double>(), 1e-6);
      const RunResult told = bench.shell(line + " --stats -v");
      EXPECT_THAT(told.out, testing::ContainsRegex("ranges checked +[0-9.]+ KiB in [0-9.e-]+ s, [0-9.e-]+ s/GiB"));
      EXPECT_THAT(told.err, testing::ContainsRegex("stored value ranges checked: [0-9.]+ KiB in "));
    }
    const RunResult plain = bench.shell("rhoray render x.rho --iso p30 --size 24x18 --force -o x.png --stats -v");
    EXPECT_THAT(plain.out, testing::ContainsRegex("ranges checked +none\n"));
  }
  const RunResult valid = bench.shell("rhoray validate x.rho --iso p30 --samples 100 --json");
  ASSERT_EQ(valid.exit_code, 0) << valid.err;
  EXPECT_GT(json::parse(valid.out)["range_proof"]["bytes"], 0);
}

TEST(StoredRanges, are_proven_once_for_all_frames) {
  const Workbench bench;
  write_file(bench / "x.rho", kinds(bench)[0].file);
  write_file(bench / "s.json", R"({"data": {"data": {"file": "x.rho"}}, "accuracy": "certified",
    "layers": [{"type": "isosurface", "isovalue": 6}], "image": {"size": [64, 48], "frames": 4},
    "camera": {"elevation": 20, "keyframes": [{"time": 0, "azimuth": 0}, {"time": 3, "azimuth": 90}]}})");
  const RunResult drawn = bench.shell("rhoray render s.json --json -o f_%d.png");
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  const json report = json::parse(drawn.out);
  ASSERT_EQ(report["frames"].size(), 4U);
  for (std::size_t frame = 0; frame < 4; ++frame)
    EXPECT_EQ(report["frames"][frame]["statistics"]["range_proof"]["bytes"].get<std::uint64_t>() > 0, frame == 0);
  EXPECT_EQ(report["range_proof"]["bytes"], report["frames"][0]["statistics"]["range_proof"]["bytes"]);
}

TEST(StoredRanges, of_an_openvdb_file_are_none_as_they_are_made_from_its_voxels) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(bench.shell("rhoray export ball.rho -o ball.vdb -q").exit_code, 0);
  const RunResult drawn =
      bench.shell("rhoray render ball.vdb --iso 100 --accuracy certified --size 64x48 --json -o ball.png");
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_EQ(json::parse(drawn.out)["statistics"]["range_proof"]["bytes"], 0);
}

}  // namespace
}  // namespace rhoray::tests
