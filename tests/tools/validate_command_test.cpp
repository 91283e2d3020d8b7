#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/sanitizers.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(ValidateCommand, finds_a_mesh_and_a_grid_within_their_limits) {
  const Workbench bench;
  bench.make_box();
  bench.make_ball();
  for (const std::string words : {"box.rho --field length --iso 0.7", "ball.rho --iso 100"}) {
    const RunResult run = bench.shell("rhoray validate " + words + " --samples 1000");
    EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
    EXPECT_THAT(run.out,
                AllOf(HasSubstr("within the limits"), HasSubstr("Hausdorff distance"), HasSubstr("false negatives")));
    EXPECT_EQ(run.err, "");
  }
}

TEST(ValidateCommand, answers_in_json) {
  const Workbench bench;
  bench.make_box();
  const RunResult run = bench.shell(
      "rhoray validate box.rho --field length --iso 0.7 --samples 500 --seed 5 --json --threads 1 --progress json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto report = nlohmann::json::parse(run.out);
  EXPECT_EQ(report["file"], "box.rho");
  EXPECT_EQ(report["field"], "length");
  EXPECT_EQ(report["isovalue"], 0.7);
  EXPECT_EQ(report["seed"], 5);
  EXPECT_EQ(report["holds"], true);
  EXPECT_EQ(report["rays"].back()["aim"], "all");
  EXPECT_GE(report["rays"].back()["rays"], 500);
  EXPECT_EQ(report["checks"].size(), 7U);
  EXPECT_THAT(run.err, HasSubstr("validating box.rho"));
}

TEST(ValidateCommand, writes_tables_and_pictures_and_replaces_them_only_with_force) {
  const Workbench bench;
  bench.make_ball();
  const std::string line = "rhoray validate ball.rho --iso 100 --samples 200 -q --report found";
  ASSERT_EQ(bench.shell(line).exit_code, 0);
  const auto contents = bench.contents();
  for (const char* name : {"report.txt", "report.json", "rays.csv", "errors.csv", "limits.csv"})
    EXPECT_GT(contents.at(std::string("found/") + name).size(), 100U) << name;
  for (const char* name : {"signed_distance.png", "depth_error.png"})
    EXPECT_THAT(contents.at(std::string("found/") + name), testing::StartsWith("\x89PNG")) << name;
  EXPECT_EQ(nlohmann::json::parse(contents.at("found/report.json"))["rays"].size(), 7U) << "camera rays, and all";
  const RunResult again = bench.shell(line);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("already exists"));
  EXPECT_EQ(bench.shell(line + " --force").exit_code, 0);
}

TEST(ValidateCommand, ends_with_6_outside_a_limit_and_names_it) {
  const Workbench bench;
  bench.make_ball();
  const RunResult run = bench.shell("rhoray validate ball.rho --iso 100 --samples 500 --max-depth-error 1e-30");
  EXPECT_EQ(run.exit_code, 6);
  EXPECT_THAT(run.out, HasSubstr("OUTSIDE THE LIMITS"));
  EXPECT_THAT(run.err, HasSubstr("rhoray validate: ball.rho: outside the limits:"));
}

TEST(ValidateCommand, refuses_what_makes_no_sense) {
  const Workbench bench;
  bench.make_ball();
  const auto refused = [&](const std::string& words, int exit_code, const std::string& fact) {
    const RunResult run = bench.shell("rhoray validate " + words);
    EXPECT_EQ(run.exit_code, exit_code) << words;
    EXPECT_THAT(run.err, HasSubstr(fact)) << words;
  };
  refused("ball.rho", 2, "--iso: missing");
  refused("ball.rho --iso 1000", 2, "1000");
  refused("ball.rho --iso 100 --samples 0", 2, "--samples");
  refused("ball.rho --iso 100 --max-depth-error 0", 2, "--max-depth-error");
  refused("ball.rho --iso 100 --field bal", 2, "bal");
  refused("ball.rho --iso 100 --report no/such", 2, "there is no folder no");
  refused("ball.rho --iso 100 --report ball.raw", 2, "is not a folder");
  refused("gone.rho --iso 100", 3, "gone.rho");
  refused("ball.raw --iso 100", 7, "ball.raw");
  if (!sanitized) refused("ball.rho --iso 100 --memory 1M", 5, "out of memory");
}

TEST(ValidateCommand, refuses_an_openvdb_file_with_a_road_that_leads_on) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(bench.shell("rhoray export ball.rho -o smoke.vdb -q").exit_code, 0);
  const RunResult refused = bench.shell("rhoray validate smoke.vdb --iso 100");
  EXPECT_EQ(refused.exit_code, 7);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("is an OpenVDB file; expected a packed file"),
                                 HasSubstr("hint: pack it first: rhoray pack smoke.vdb\n")));
  ASSERT_EQ(bench.shell("rhoray pack smoke.vdb -q").exit_code, 0);
  const RunResult run = bench.shell("rhoray validate smoke.rho --iso 100 --samples 1000");
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
}

TEST(ValidateCommand, catches_methods_that_are_wrong) {
  const Workbench bench;
  bench.make_ball();
  const RunResult sampled = bench.shell("rhoray validate ball.rho --iso 100 --samples 1000 --method sampled:1");
  EXPECT_EQ(sampled.exit_code, 6);
  EXPECT_THAT(sampled.err,
              AllOf(HasSubstr("ball.rho: outside the limits: false negatives "), HasSubstr("different cell ")));
}

TEST(ValidateCommand, refuses_a_damaged_file) {
  const Workbench bench;
  bench.make_ball();
  std::string bytes = read_file(bench / "ball.rho");
  bytes[4096 + 100] = static_cast<char>(bytes[4096 + 100] ^ 1);
  write_file(bench / "broken.rho", bytes);
  const RunResult run = bench.shell("rhoray validate broken.rho --iso 100");
  EXPECT_EQ(run.exit_code, 4) << run.err;
  EXPECT_THAT(run.err, HasSubstr("broken.rho"));
}

}  // namespace
}  // namespace rhoray::tests
