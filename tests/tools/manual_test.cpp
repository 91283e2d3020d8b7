#include "tools/rhoray/cli/manual.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "formats/base/text.h"
#include "tools/rhoray/cli/help.h"
#include "tools/rhoray/subcommands.h"

// tests/install checks the pages with mandoc.
namespace rhoray::tools {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* date = "2026-11-27";

/// The lines that begin an entry of a list, without escapes.
std::vector<std::string> items_of(const std::string& page) {
  std::vector<std::string> items;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(".It ")) continue;
    for (std::size_t at = 0; (at = line.find('\\', at)) != std::string::npos;)
      line.erase(at, line[at + 1] == ':' ? 2 : 1);
    items.push_back(line);
  }
  return items;
}

TEST(Manual, has_every_option_of_every_subcommand_once) {
  for (const Subcommand& each : all_subcommands()) {
    const std::vector<std::string> items = items_of(manual_page(each, date));
    for (const Option& row : rows_with_help(each)) {
      std::string item = ".It Ar " + row.names;
      if (row.names.starts_with("-")) {
        item = ".It Fl " + row.names.substr(1);
        if (const std::size_t comma = item.find(','); comma != std::string::npos) item.replace(comma, 2, " , Fl ");
        if (!row.value.empty()) item += " Ar " + row.value;
      }
      EXPECT_EQ(std::count(items.begin(), items.end(), item), 1) << each.name << ": " << item;
    }
  }
}

TEST(Manual, begins_with_name_and_summary) {
  const Subcommand subcommand{.name = "show",
                              .summary = "Show `this` file's content",
                              .examples = {"rhoray show a.rho"},
                              .options = {},
                              .run = {}};
  EXPECT_THAT(manual_page(subcommand, date), StartsWith(".Dd November 27, 2026\n.Dt RHORAY-SHOW 1\n"));
  EXPECT_THAT(manual_page(subcommand, date), HasSubstr("\n.Nd Show \\(lqthis\\(rq file\\(aqs content\n"));
}

TEST(Manual, keeps_what_roff_would_interpret) {
  const Subcommand subcommand{
      .name = "show",
      .summary = "Show",
      .examples = {"rhoray show 'a\\b'"},
      .options = {{.names = "--file", .value = "F", .help = ".rho or ~/a^b. Then -x", .take = {}}},
      .run = {}};
  const std::string page = manual_page(subcommand, date);
  EXPECT_THAT(page, HasSubstr("\n.It Fl \\-file Ar F\n\\&.rho or \\(ti/a\\(hab.\nThen \\-x.\n"));
  EXPECT_THAT(page, HasSubstr("rhoray show \\(aqa\\eb\\(aq\n"));
}

TEST(Manual, of_the_program_names_all_subcommands_exit_codes_and_variables) {
  const std::string page = manual_page(all_subcommands(), date);
  for (const Subcommand& each : all_subcommands()) EXPECT_THAT(page, HasSubstr(concat(".Xr rhoray-", each.name, " 1")));
  for (const char* part :
       {".Sh EXIT STATUS\n", ".Sh ENVIRONMENT\n", "\n.It RHORAY_MACHINE\n", "\n.It 7\nunknown file type"})
    EXPECT_THAT(page, HasSubstr(part));
}

}  // namespace
}  // namespace rhoray::tools
