// Tests the single command that repeats the whole study, with small data.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "formats/base/text.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

RunResult every_figure(std::vector<std::string> words, const TemporaryFolder& folder) {
  words.insert(words.begin(), RHORAY_SOURCE_DIR "/tools/lab/every_figure");
  words.insert(words.end(), {"--bin", std::filesystem::path(RHORAY_PROGRAM).parent_path().string()});
  return run_program(words, folder.path());
}

TEST(EveryFigure, makes_all_parts_that_need_no_data_from_the_field) {
  const TemporaryFolder folder;
  const RunResult listed = every_figure({"--list"}, folder);
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  const RunResult made = every_figure({"out", "--quick"}, folder);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string page = read_file(folder / "out/figures.md");
  int part_count = 0;
  for (std::size_t at = 0; at < listed.out.size(); at = listed.out.find('\n', at) + 1) {
    const std::string name = listed.out.substr(at, listed.out.find(' ', at) - at);
    ++part_count;
    const bool is_of_the_field = name.ends_with("_thorax") || name.ends_with("_post");
    EXPECT_EQ(std::filesystem::exists(folder / concat("out/", name, "/commands.txt")), !is_of_the_field) << name;
    EXPECT_EQ(page.find(concat("## ", name, ":")) != std::string::npos, !is_of_the_field) << name;
    EXPECT_EQ(made.err.find(concat(name, ": left out: ")) != std::string::npos, is_of_the_field) << name;
    if (is_of_the_field) continue;
    int table_count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / ("out/" + name)))
      if (entry.path().extension() == ".json" && entry.path().stem() != "textured") {
        EXPECT_FALSE(nlohmann::json::parse(read_file(entry.path()))["rows"].empty()) << entry.path();
        ++table_count;
      }
    EXPECT_GE(table_count, 1) << name;
  }
  EXPECT_GE(part_count, 15);

  const RunResult again = every_figure({"out", "--quick", "--parts", "bits_smooth,table_1"}, folder);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("bits_smooth: is there already"), std::string::npos) << again.err;
}

TEST(EveryFigure, says_what_failed_and_goes_on) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "given");
  write_file(folder / "given/smooth.rho", "no packed file");
  const RunResult result =
      every_figure({"out", "--quick", "--data", "given", "--parts", "bits_smooth,bits_marschner_lobb"}, folder);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("bits_smooth: FAILED"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("bits_marschner_lobb: done"), std::string::npos) << result.err;
}

TEST(EveryFigure, refuses_parts_that_are_not_there) {
  const TemporaryFolder folder;
  EXPECT_EQ(every_figure({"out", "--parts", "table_7"}, folder).exit_code, 2);
  EXPECT_EQ(every_figure({}, folder).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace
}  // namespace rhoray::tests
