#include "tools/rhoray/cli/completion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/text.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/cli/given_words.h"
#include "tools/rhoray/cli/help.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> no_fields(const std::filesystem::path&) {
  return {};
}

Completion completion(const std::vector<std::string>& words, const FieldsOfFile& fields_of = no_fields) {
  return completion_of(all_subcommands(), words, fields_of);
}

std::vector<std::string> words_of(const Completion& completion) {
  std::vector<std::string> words;
  for (const Completion::Candidate& candidate : completion.candidates) words.push_back(candidate.word);
  return words;
}

std::vector<std::string> candidates(const std::vector<std::string>& words) {
  return words_of(completion(words));
}

TEST(Completion, offers_every_subcommand) {
  const std::vector<std::string> words = candidates({""});
  for (const Subcommand& each : all_subcommands()) EXPECT_THAT(words, Contains(each.name));
  EXPECT_THAT(candidates({"re"}), ElementsAre("render", "resample"));
  EXPECT_THAT(candidates({"help", "re"}), ElementsAre("render", "resample"));
  EXPECT_THAT(candidates({"--v"}), ElementsAre("--version"));
  EXPECT_THAT(candidates({"rendr", ""}), IsEmpty());
}

TEST(Completion, offers_every_option_of_every_subcommand_with_its_help_and_every_choice) {
  std::size_t options = 0, choices = 0;
  for (const Subcommand& each : all_subcommands()) {
    const Completion offered = completion({each.name, "-"});
    for (const Option& row : rows_with_help(each)) {
      if (is_positional(row)) continue;
      const auto found = std::find_if(offered.candidates.begin(), offered.candidates.end(),
                                      [&](const auto& candidate) { return candidate.word == long_name(row); });
      ASSERT_NE(found, offered.candidates.end()) << each.name << ' ' << row.names;
      EXPECT_EQ(found->help, row.help);
      ++options;
      for (const std::string& choice : row.choices) {
        EXPECT_THAT(candidates({each.name, long_name(row), ""}), Contains(choice)) << row.names;
        EXPECT_THAT(candidates({each.name, concat(long_name(row), "=")}), Contains(choice)) << row.names;
        ++choices;
      }
    }
  }
  EXPECT_GT(options, 300U);
  EXPECT_GT(choices, 200U);
}

TEST(FuzzDictionary, knows_every_option) {
  const std::string words = tests::read_file(RHORAY_SOURCE_DIR "/tests/fuzz/dictionaries/command_line.dict");
  for (const Subcommand& each : all_subcommands())
    for (const Option& row : rows_with_help(each)) {
      if (is_positional(row)) continue;
      EXPECT_THAT(words, HasSubstr(concat("\"\\x0a", long_name(row), "\\x0a\""))) << each.name;
    }
}

TEST(Completion, offers_what_begins_like_the_word) {
  EXPECT_THAT(candidates({"render", "head.rho", "--colormap", "vi"}), ElementsAre("viridis", "viridis_r"));
  EXPECT_THAT(candidates({"render", "head.rho", "--colormap=vi"}), ElementsAre("viridis", "viridis_r"));
  EXPECT_THAT(candidates({"render", "--accuracy", "e"}), ElementsAre("exact"));
  EXPECT_THAT(candidates({"render", "--shadows=t"}), IsEmpty()) << "it takes no value";
  EXPECT_THAT(candidates({"render", "--unknown=t"}), IsEmpty());
  EXPECT_THAT(candidates({"render", "--", "-"}), Not(Contains("--iso")));
}

TEST(Completion, says_where_paths_belong) {
  EXPECT_EQ(completion({"render", ""}).paths, Completion::Paths::files);
  EXPECT_EQ(completion({"render", "head.rho", "-o", ""}).paths, Completion::Paths::files);
  EXPECT_EQ(completion({"render", "head.rho", "--texture", ""}).paths, Completion::Paths::files);
  EXPECT_EQ(completion({"accuracy", "head.rho", "-o", ""}).paths, Completion::Paths::folders);
  EXPECT_EQ(completion({"render", "head.rho", "--iso", ""}).paths, Completion::Paths::none);
  EXPECT_EQ(completion({"render", "-"}).paths, Completion::Paths::none);
}

TEST(Completion, offers_fields_of_the_files_in_front) {
  const FieldsOfFile fields_of = [](const std::filesystem::path& file) -> std::vector<std::string> {
    if (file == "heart.rho") return {"pressure", "potential"};
    return {"density"};
  };
  EXPECT_THAT(words_of(completion({"render", "heart.rho", "--iso", "0.3", "--color-by", "p"}, fields_of)),
              ElementsAre("potential", "pressure"));
  EXPECT_THAT(words_of(completion({"render", "heart.rho", "other.rho", "--field", ""}, fields_of)),
              ElementsAre("density", "potential", "pressure"));
  EXPECT_THAT(words_of(completion({"render", "-o", "heart.rho", "--field", ""}, fields_of)), IsEmpty())
      << "the value of another option is no input";
}

TEST(Completion, is_printed_by_the_program_with_fields_of_packed_files) {
  const tests::Workbench bench;
  bench.make_box();
  const tests::RunResult fields = bench.rhoray({"complete", "render", "box.rho", "--field", ""});
  EXPECT_EQ(fields.exit_code, 0);
  EXPECT_EQ(fields.out, "height\tfield of box.rho\nlength\tfield of box.rho\n");
  EXPECT_EQ(bench.rhoray({"complete", "verify", ""}).out, ":files\n");
  EXPECT_EQ(bench.rhoray({"complete"}).out, "");
  EXPECT_EQ(bench.rhoray({"complete", "render", "missing.rho", "--field", ""}).out, "");
}

TEST(HelpSubcommand, prints_the_help_of_a_subcommand) {
  const tests::Workbench bench;
  EXPECT_EQ(bench.rhoray({"help", "render"}).out, bench.rhoray({"render", "--help"}).out);
  EXPECT_EQ(bench.rhoray({"help"}).out, bench.rhoray({"--help"}).out);
  const tests::RunResult unknown = bench.rhoray({"help", "rendr"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("no subcommand rendr"), HasSubstr("render")));
  EXPECT_EQ(bench.rhoray({"help", "render", "pack"}).exit_code, 2);
}

}  // namespace
}  // namespace rhoray::tools
