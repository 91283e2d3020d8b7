#include <gmock/gmock.h>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

RunResult recipes(std::vector<std::string> words, const TemporaryFolder& folder) {
  words.insert(words.begin(), RHORAY_RECIPES_PROGRAM);
  return run_program(words, folder.path());
}

TEST(RecipesProgram, ends_every_help_with_an_example) {
  const TemporaryFolder folder;
  for (const char* recipe : {"torso-surface", "torso-potential", "torso-ct", "marschner-lobb", "smooth", "turbulent"}) {
    const RunResult result = recipes({recipe, "--help"}, folder);
    EXPECT_EQ(result.exit_code, 0);
    const auto example = result.out.rfind("Example:\n  rhoray-recipes " + std::string(recipe));
    ASSERT_NE(example, std::string::npos) << result.out;
    EXPECT_EQ(result.out.find("--help", example), std::string::npos);
  }
}

TEST(RecipesProgram, is_silent_when_it_succeeds) {
  const TemporaryFolder folder;
  for (const auto& words :
       std::vector<std::vector<std::string>>{{"torso-surface", "-o", "torso.smesh", "--cells", "5000"},
                                             {"torso-ct", "-o", "ct.nhdr", "--size", "8x9x10"},
                                             {"marschner-lobb", "-o", "ml.nhdr", "--size", "4", "--type", "uint8"}}) {
    const RunResult result = recipes(words, folder);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out + result.err, "");
  }
  EXPECT_EQ(std::filesystem::file_size(folder / "ct.raw"), 8u * 9 * 10 * 2);
  EXPECT_EQ(std::filesystem::file_size(folder / "ml.raw"), 64u);
  EXPECT_TRUE(std::filesystem::exists(folder / "torso.mtr"));
}

TEST(RecipesProgram, refuses_requests_without_sense_and_leaves_nothing_behind) {
  const TemporaryFolder folder;
  for (const auto& words :
       std::vector<std::vector<std::string>>{{},
                                             {"torso"},
                                             {"torso-ct", "--sice", "3"},
                                             {"torso-ct", "-o", "ct.nhdr", "--size", "3x4"},
                                             {"torso-ct", "-o", "ct.nhdr", "--size", "3x4x99999"},
                                             {"torso-surface", "-o", "torso.stl"},
                                             {"marschner-lobb", "-o", "m.nhdr", "--type", "half"}}) {
    const RunResult result = recipes(words, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err, "");
  }
  const RunResult missing = recipes({"torso-potential", "none.vtu", "-o", "out.vtu"}, folder);
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_THAT(missing.err, HasSubstr("none.vtu"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(RecipesProgram, replaces_files_only_when_told) {
  const TemporaryFolder folder;
  write_file(folder / "ml.nhdr", "mine");
  const std::vector<std::string> words{"marschner-lobb", "-o", "ml.nhdr", "--size", "3"};
  const RunResult refused = recipes(words, folder);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--force"));
  EXPECT_EQ(read_file(folder / "ml.nhdr"), "mine");
  std::vector<std::string> forced = words;
  forced.push_back("--force");
  EXPECT_EQ(recipes(forced, folder).exit_code, 0);
  EXPECT_EQ(std::filesystem::file_size(folder / "ml.raw"), 27u * 4);
}

}  // namespace
}  // namespace rhoray::tests
