#include "tools/rhoray/cli/help.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>
#include <sstream>

#include "formats/base/text.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

void expect_width(const std::string& text, std::size_t width) {
  EXPECT_THAT(text, EndsWith("\n"));
  for (const std::string& line : lines_of(text)) {
    EXPECT_LE(line.size(), width) << line;
    EXPECT_THAT(line, Not(EndsWith(" ")));
  }
}

/// A text without its line breaks and indents.
std::string unwrapped(const std::string& text) {
  std::string all;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) all += (all.empty() ? "" : " ") + word;
  return all;
}

/// The environment variable COLUMNS, for one test.
class Columns {
 public:
  explicit Columns(const char* value) {
    if (const char* old = std::getenv("COLUMNS")) old_ = old;
    value ? ::setenv("COLUMNS", value, 1) : ::unsetenv("COLUMNS");
  }
  ~Columns() { old_ ? ::setenv("COLUMNS", old_->c_str(), 1) : ::unsetenv("COLUMNS"); }
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

 private:
  std::optional<std::string> old_;
};

TEST(HelpText, is_wrapped_at_words_and_cuts_only_words_that_are_longer_than_a_line) {
  EXPECT_THAT(wrapped("one two  three\nfour", 9), ElementsAre("one two", "three", "four"));
  EXPECT_THAT(wrapped("one two three", 7), ElementsAre("one two", "three"));
  EXPECT_THAT(wrapped("a abcdefghij b", 4), ElementsAre("a", "abcd", "efgh", "ij b"));
  EXPECT_THAT(wrapped("a|bb|ccc|d", 7), ElementsAre("a|bb|", "ccc|d"));
  EXPECT_THAT(wrapped("at most 90 % of it", 10), ElementsAre("at most", "90 % of it"));
  EXPECT_THAT(wrapped("", 9), ElementsAre());
}

TEST(HelpText, has_a_hanging_indent_and_gives_long_terms_a_line_of_their_own) {
  const HelpSection section{
      .heading = "Camera",
      .entries = {{"--fov DEG", "Vertical field of view in degrees; default 30, as for a photograph"},
                  {"--nineteen-signs-19", "This term leaves no room"},
                  {"--ortho", ""},
                  {"", "A paragraph stands below the terms, and is wrapped as they are."}}};
  EXPECT_EQ(section_text(section, 60),
            "Camera:\n"
            "  --fov DEG           Vertical field of view in degrees;\n"
            "                      default 30, as for a photograph\n"
            "  --nineteen-signs-19\n"
            "                      This term leaves no room\n"
            "  --ortho\n"
            "  A paragraph stands below the terms, and is wrapped as they\n"
            "  are.\n");
}

TEST(HelpText, continues_long_examples_as_a_shell_reads_them_with_options_beside_their_values) {
  EXPECT_EQ(example_text("rhoray info head.rho", 60), "  rhoray info head.rho\n");
  EXPECT_EQ(example_text("rhoray render head.rho --iso 500 --view -y --size 1080p -o skin.png", 60),
            "  rhoray render head.rho --iso 500 --view -y \\\n"
            "      --size 1080p -o skin.png\n");
  EXPECT_EQ(example_text("rhoray tetrahedralize scalp.tri skull.tri brain.tri --max-volume=1:50 -o head.vtu", 60),
            "  rhoray tetrahedralize scalp.tri skull.tri brain.tri \\\n"
            "      --max-volume=1:50 -o head.vtu\n");
}

TEST(HelpText, is_as_wide_as_the_terminal_from_60_to_100_columns) {
  const auto width_with = [](const char* columns) {
    const Columns variable(columns);
    return help_width();
  };
  EXPECT_EQ(width_with("72"), 72U);
  EXPECT_EQ(width_with("20"), 60U);
  EXPECT_EQ(width_with("400"), 100U);
  for (const char* useless : {"", "0", "wide", "80x"}) EXPECT_EQ(width_with(useless), width_with(nullptr)) << useless;
}

TEST(Help, has_no_line_beyond_the_width) {
  const std::vector<Subcommand> subcommands = all_subcommands();
  for (const std::size_t width : {60U, 80U, 100U}) {
    expect_width(overview(subcommands, width), width);
    for (const Subcommand& each : subcommands)
      for (const HelpLevel level : {HelpLevel::common, HelpLevel::all}) {
        SCOPED_TRACE(concat(each.name, " at ", width));
        expect_width(help_text(each, level, width), width);
      }
  }
}

TEST(Help, of_the_program_lists_the_subcommands_by_group) {
  const std::vector<Subcommand> subcommands = all_subcommands();
  const std::string text = overview(subcommands, 80);
  for (const Subcommand& each : subcommands) {
    EXPECT_NE(each.group, Subcommand{}.group) << each.name;
    const std::size_t group = text.find(concat("\n\n", each.group, ":\n"));
    ASSERT_NE(group, std::string::npos) << each.group;
    const std::string section = text.substr(group, text.find("\n\n", group + 2) - group);
    EXPECT_THAT(section, HasSubstr(concat("\n  ", each.name, " ")));
    EXPECT_THAT(section, HasSubstr(each.summary));
  }
}

TEST(Subcommands, are_made_one_at_a_time_by_their_names) {
  for (const Subcommand& each : all_subcommands()) {
    const std::vector<Subcommand> made = subcommands_for(each.name);
    ASSERT_EQ(made.size(), 1U) << each.name;
    EXPECT_EQ(made[0].name, each.name);
  }
  for (const char* other : {"", "--help", "rendr"})
    EXPECT_EQ(subcommands_for(other).size(), all_subcommands().size()) << other;
}

TEST(Help, starts_with_summary_usage_and_at_most_three_examples) {
  for (const Subcommand& each : all_subcommands()) {
    SCOPED_TRACE(each.name);
    const std::vector<std::string> lines = lines_of(help_text(each, HelpLevel::common, 80));
    ASSERT_GE(lines.size(), 6U);
    EXPECT_EQ(lines[0], each.summary);
    EXPECT_THAT(lines[1], StartsWith(concat("Usage: rhoray ", each.name, " ")));
    EXPECT_THAT(lines[1], EndsWith(" [OPTIONS]"));
    EXPECT_EQ(lines[3], "Examples:");
    const auto examples = std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.starts_with(concat("  rhoray ", each.name));
    });
    EXPECT_GE(examples, 2);
    EXPECT_LE(examples, 3);
  }
}

TEST(Help, hides_options_for_experts_which_help_all_shows_with_details_and_all_examples) {
  std::size_t hidden = 0;
  for (const Subcommand& each : all_subcommands()) {
    SCOPED_TRACE(each.name);
    const std::string common = help_text(each, HelpLevel::common, 80), all = help_text(each, HelpLevel::all, 80);
    EXPECT_EQ(lines_of(common).back(), concat("More options and examples: rhoray ", each.name, " --help-all"));
    EXPECT_THAT(all, Not(HasSubstr("More options")));
    const std::vector<std::string> common_lines = lines_of(common), all_lines = lines_of(all);
    const auto lists = [](const std::vector<std::string>& lines, const Option& row) {
      const std::string term = concat("  ", row.names.substr(0, row.names.find(',')));
      return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
        return line.starts_with(term) &&
               (line.size() == term.size() || line[term.size()] == ' ' || line[term.size()] == ',');
      });
    };
    for (const Option& row : rows_with_help(each)) {
      EXPECT_EQ(lists(common_lines, row), !row.is_expert) << row.names;
      EXPECT_TRUE(lists(all_lines, row)) << row.names;
      EXPECT_THAT(unwrapped(all), HasSubstr(row.details.empty() ? row.help : concat(row.help, ". ", row.details)));
      hidden += row.is_expert;
    }
    for (const std::string& example : each.examples) EXPECT_THAT(all, HasSubstr(example_text(example, 80)));
  }
  EXPECT_GT(hidden, 30U);
}

bool takes_files(const Subcommand& subcommand) {
  return std::any_of(subcommand.options.begin(), subcommand.options.end(), [](const Option& row) {
    return row.kind == Option::Kind::file || row.kind == Option::Kind::files;
  });
}

/// Up to about a dozen options are one list; more are in groups.
TEST(Help, shows_many_options_in_groups) {
  for (const Subcommand& each : all_subcommands()) {
    SCOPED_TRACE(each.name);
    std::set<std::string> groups;
    for (const Option& row : rows_with_help(each)) {
      EXPECT_NE(row.group, "") << row.names;
      groups.insert(row.group);
    }
    const std::string help = help_text(each, HelpLevel::all, 80);
    for (const std::string& group : groups) EXPECT_THAT(help, HasSubstr(concat("\n\n", group, ":\n")));
    if (!takes_files(each))
      EXPECT_THAT(groups, ElementsAre("Options"));
    else if (each.options.size() > 14)
      EXPECT_EQ(groups.count("Options"), 0U);
    else
      EXPECT_THAT(groups, ElementsAre("Input", "Options"));
  }
}

TEST(Help, says_little_about_each_option) {
  for (const Subcommand& each : all_subcommands())
    for (const Option& row : rows_with_help(each)) {
      SCOPED_TRACE(concat(each.name, " ", row.names));
      ASSERT_FALSE(row.help.empty());
      std::size_t sentences = 1;
      for (std::size_t at = 0; (at = row.help.find(". ", at)) != std::string::npos; ++at) ++sentences;
      EXPECT_LE(sentences, 2U);
      EXPECT_LE(row.help.size(), 120U);
      for (const std::string& text : {row.help, row.details}) EXPECT_THAT(text, Not(EndsWith(".")));
    }
}

TEST(Help, keeps_the_choices_of_an_option_as_data) {
  std::string word;
  const Option row = choice_option("--mode", {"iso", "mip"}, "Mode", word);
  EXPECT_THAT(row.choices, ElementsAre("iso", "mip"));
  EXPECT_EQ(row.value, "iso|mip");
}

TEST(Help, is_printed_by_the_program_in_the_width_of_COLUMNS) {
  const tests::Workbench bench;
  const auto printed = [&](const std::string& words) {
    SCOPED_TRACE(words);
    const tests::RunResult run = bench.shell(concat("COLUMNS=60 rhoray ", words));
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_EQ(run.err, "");
    return run.out;
  };
  const std::vector<Subcommand> subcommands = all_subcommands();
  for (const char* option : {"--help", "-h", "--help-all"}) EXPECT_EQ(printed(option), overview(subcommands, 60));
  for (const Subcommand& each : subcommands) {
    EXPECT_EQ(printed(concat(each.name, " --help")), help_text(each, HelpLevel::common, 60));
    EXPECT_EQ(printed(concat(each.name, " -h")), help_text(each, HelpLevel::common, 60));
    EXPECT_EQ(printed(concat(each.name, " --help-all")), help_text(each, HelpLevel::all, 60));
  }
}

/// None of the files exists: the command reads the options and names the first missing file.
TEST(Help, has_examples_whose_options_exist) {
  const tests::Workbench bench;
  for (const Subcommand& each : all_subcommands())
    for (const std::string& example : each.examples) {
      const tests::RunResult run = bench.shell(example_text(example, 60));
      EXPECT_EQ(run.exit_code, takes_files(each) ? 3 : 0) << example << "\n" << run.err;
    }
}

}  // namespace
}  // namespace rhoray::tools
