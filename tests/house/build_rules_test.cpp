#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

/// Our source files in the compilation database whose command breaks a rule, with the rule.
std::vector<std::string> breaches_of_flags(const nlohmann::json& database, const std::string& source_dir) {
  std::vector<std::string> found;
  for (const nlohmann::json& entry : database) {
    const std::string file = entry.at("file"), command = " " + entry.at("command").get<std::string>() + " ";
    if (!file.starts_with(source_dir + "/")) continue;
    for (const char* flag :
         {"-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Werror", "-ffp-contract=off", "-std=c++20"})
      if (command.find(std::string(" ") + flag + " ") == command.npos) found.push_back(file + " lacks " + flag);
    for (const char* flag : {"-ffast-math", "-Ofast", "-march=", "-ffp-contract=fast"})
      if (command.find(std::string(" ") + flag) != command.npos) found.push_back(file + " has " + flag);
  }
  return found;
}

TEST(BuildRules, are_seen_to_be_broken) {
  const std::string good =
      "g++ -std=c++20 -Wall -Wextra -Wshadow -Wconversion -Werror -ffp-contract=off -o a.o -c a.cpp";
  const auto entry = [](const std::string& file, const std::string& command) {
    return nlohmann::json{{"file", file}, {"command", command}};
  };
  std::string without_werror = good, with_march = good + " -march=native";
  without_werror.erase(without_werror.find("-Werror"), 8);
  EXPECT_THAT(
      breaches_of_flags(nlohmann::json::array({entry("/s/a.cpp", good), entry("/elsewhere/b.cpp", "g++ b.cpp")}), "/s"),
      testing::IsEmpty());
  EXPECT_THAT(breaches_of_flags(nlohmann::json::array({entry("/s/a.cpp", without_werror)}), "/s"),
              testing::ElementsAre("/s/a.cpp lacks -Werror"));
  EXPECT_THAT(breaches_of_flags(nlohmann::json::array({entry("/s/a.cpp", with_march)}), "/s"),
              testing::ElementsAre("/s/a.cpp has -march="));
}

TEST(House, compiles_every_own_source_with_one_set_of_warnings_and_one_arithmetic) {
  const auto database = nlohmann::json::parse(read_file(RHORAY_BINARY_DIR "/compile_commands.json"));
  EXPECT_GT(database.size(), 20U);
  EXPECT_THAT(breaches_of_flags(database, RHORAY_SOURCE_DIR), testing::IsEmpty());
}

TEST(House, links_tetgen_and_cgals_number_types_into_the_worker_only) {
  // GMP itself, under the LGPL, is also used by render/exact
  const std::regex viral("libtet|libmpfr|libCGAL");
  const auto libraries = [](const char* program) { return run_program({"ldd", program}).out; };
  EXPECT_TRUE(std::regex_search(libraries(RHORAY_TETGEN_WORKER), viral)) << "is this still how the worker is linked?";
  EXPECT_FALSE(std::regex_search(libraries(RHORAY_PROGRAM), viral));
}

/// Configures in a folder as on a machine that lacks the libraries of components and tests. Blanks
/// and line ends of what CMake says become single blanks.
RunResult configure_without_libraries(const TemporaryFolder& folder, const std::string& definition) {
  std::vector<std::string> words{"cmake",           "--preset", "render-only",          "-S",
                                 RHORAY_SOURCE_DIR, "-B",       folder.path().string(), definition};
  for (const std::string library : {"CGAL", "Eigen3", "GTest", "VTK"})
    words.push_back("-DCMAKE_DISABLE_FIND_PACKAGE_" + library + "=ON");
  RunResult run = run_program(words, RHORAY_SOURCE_DIR);
  run.err = std::regex_replace(run.err, std::regex("\\s+"), " ");
  return run;
}

TEST(House, is_configured_without_the_libraries_of_components_that_are_left_out) {
  const TemporaryFolder folder;
  const RunResult bare = configure_without_libraries(folder, "-DRHORAY_COMPONENTS=");
  EXPECT_EQ(bare.exit_code, 0) << bare.err;
  const auto expect_refusal = [&](const std::string& definition, const std::string& sentence) {
    const RunResult refused = configure_without_libraries(folder, definition);
    EXPECT_NE(refused.exit_code, 0) << definition;
    EXPECT_THAT(refused.err, testing::HasSubstr(sentence)) << definition;
  };
  expect_refusal("-DRHORAY_COMPONENTS=import", "The component 'import' needs VTK, which was not found: install it");
  expect_refusal("-DRHORAY_COMPONENTS=vdb;tetgen", "(Debian: libcgal-dev), or leave 'tetgen' out");
  expect_refusal("-DRHORAY_COMPONENTS=textgen", "RHORAY_COMPONENTS: found 'textgen'; expected all, or some of import");
  expect_refusal("-DRHORAY_TESTS=ON", "need the component 'import': add it to RHORAY_COMPONENTS");
}

TEST(House, is_formatted_by_clang_format) {
  if (run_program({"sh", "-c", "command -v clang-format"}).exit_code != 0)
    GTEST_SKIP() << "clang-format is not installed";
  const RunResult listed = run_program(
      {"git", "-C", RHORAY_SOURCE_DIR, "ls-files", "--cached", "--others", "--exclude-standard", "*.h", "*.cpp"});
  if (listed.exit_code != 0) GTEST_SKIP() << "the sources are not a git working tree";
  const RunResult checked =
      run_program({"sh", "-c",
                   "cd '" RHORAY_SOURCE_DIR "' && git ls-files --cached --others --exclude-standard "
                   "'*.h' '*.cpp' | xargs clang-format --dry-run -Werror"});
  EXPECT_EQ(checked.exit_code, 0) << checked.err.substr(0, 4000);
}

}  // namespace
}  // namespace rhoray::tests
