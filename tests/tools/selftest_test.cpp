#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// The results by the names of checks.
std::map<std::string, json> results(const RunResult& run) {
  std::map<std::string, json> results;
  const json all = json::parse(run.out);
  for (const json& check : all["checks"]) results[check["name"].get<std::string>()] = check;
  return results;
}

TEST(Selftest, passes_and_leaves_nothing) {
  const Workbench bench;
  std::filesystem::create_directory(bench / "tmp");
  const RunResult run = bench.shell("TMPDIR=tmp rhoray selftest --json");
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  for (const auto& [name, check] : results(run)) {
    if (name.starts_with("kernels avx"))
      EXPECT_NE(check["result"], "FAILED") << check;  // not every processor has them
    else
      EXPECT_EQ(check["result"], "passed") << check;
  }
  EXPECT_TRUE(std::filesystem::is_empty(bench / "tmp"));
}

TEST(Selftest, finds_a_worker_that_fails_and_names_packages_of_those_that_are_missing) {
  const Workbench bench;
  for (const char* folder : {"tmp", "workers"}) std::filesystem::create_directory(bench / folder);
  std::filesystem::copy_file("/bin/false", bench / "workers/rhoray-vdb-worker");
  const RunResult run = bench.shell("TMPDIR=$PWD/tmp RHORAY_WORKER_DIR=$PWD/workers rhoray selftest --json");
  EXPECT_EQ(run.exit_code, 1);
  auto found = results(run);
  EXPECT_EQ(found["OpenVDB"]["result"], "FAILED");
  EXPECT_THAT(found["OpenVDB"]["text"].get<std::string>(),
              HasSubstr("`rhoray export volume.rho -o volume.vdb` ended with"));
  EXPECT_EQ(found["import"]["result"], "left out");
  EXPECT_THAT(found["import"]["text"].get<std::string>(), HasSubstr("package rhoray-import"));
  EXPECT_TRUE(std::filesystem::is_empty(bench / "tmp"));
}

}  // namespace
}  // namespace rhoray::tests
