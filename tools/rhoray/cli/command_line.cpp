#include "tools/rhoray/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/mapped_file.h"
#include "formats/base/nearest_name.h"
#include "tools/rhoray/cli/help.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/version.h"

namespace rhoray::tools {

namespace {

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

bool takes_no_value(const Option& row) {
  return row.kind == Option::Kind::flag || row.kind == Option::Kind::answer;
}

/// Those whose value ends in dots take one value each time that they are given.
bool may_be_repeated(const Option& row) {
  return row.kind == Option::Kind::value && row.value.ends_with("...");
}

/// The options of one subcommand in CLI11's hands, row by row.
std::vector<CLI::Option*> add_options(CLI::App& app, const Subcommand& subcommand) {
  std::vector<CLI::Option*> added;
  const CLI::callback_t taken_later = [](const CLI::results_t&) { return true; };
  for (const Option& row : subcommand.options) {
    if (takes_no_value(row)) {
      added.push_back(app.add_flag(row.names, row.help));
      continue;
    }
    CLI::Option* option = app.add_option(row.names, taken_later, row.help);
    option->type_name(row.value);
    option->expected(1);
    if (may_be_repeated(row)) option->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args(false);
    if (row.kind == Option::Kind::files) option->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args();
    added.push_back(option);
  }
  return added;
}

std::vector<std::string> long_names(const Subcommand& subcommand) {
  std::vector<std::string> names;
  for (const Option& row : rows_with_help(subcommand))
    if (const std::size_t at = row.names.find("--"); at != std::string::npos) names.push_back(row.names.substr(at));
  return names;
}

[[noreturn]] void refuse_extra(const Subcommand& subcommand, const std::vector<std::string>& extras) {
  for (const std::string& extra : extras)
    if (extra.starts_with("-")) {
      const std::string name = extra.substr(0, extra.find('='));
      const std::string hint = did_you_mean(name, long_names(subcommand));
      throw Error(ErrorCode::usage, concat("unknown option ", name),
                  hint.empty() ? concat("`rhoray ", subcommand.name, " --help` lists the options") : hint);
    }
  throw Error(ErrorCode::usage, concat("unexpected argument '", extras.front(), "'"),
              concat("`rhoray ", subcommand.name, " --help` shows what is expected"));
}

/// Prints the requested answer, if there is one.
bool answers(const Subcommand& subcommand, std::span<CLI::Option* const> added) {
  for (std::size_t i = 0; i < added.size(); ++i)
    if (subcommand.options[i].kind == Option::Kind::answer && added[i]->count() > 0) {
      subcommand.options[i].take({});
      return true;
    }
  return false;
}

/// Passes the given values to the rows; errors get the option's name as prefix.
void take_values(const Subcommand& subcommand, std::span<CLI::Option* const> added) {
  for (std::size_t i = 0; i < added.size(); ++i) {
    const Option& row = subcommand.options[i];
    const bool positional = row.kind == Option::Kind::file || row.kind == Option::Kind::files;
    if (positional && added[i]->count() == 0)
      throw Error(ErrorCode::usage, concat("no ", row.names, " given"),
                  concat("`rhoray ", subcommand.name, " --help` starts with examples"));
    for (const std::string& text : added[i]->results()) try {
        row.take(takes_no_value(row) ? std::string{} : text);
      } catch (const Error& error) {
        throw Error(error.code(), concat(row.names.substr(row.names.find(',') + 1), ": ", error.what()), error.hint());
      }
  }
}

int run_subcommand(const Subcommand& subcommand, int argc, const char* const* argv) {
  CLI::App app(subcommand.summary, "rhoray " + subcommand.name);
  app.allow_extras();  // refused by us, with what was probably meant
  app.set_help_all_flag("--help-all");
  const std::vector<CLI::Option*> added = add_options(app, subcommand);
  const auto print_help = [&](HelpLevel level) {
    std::fputs(help_text(subcommand, level, help_width()).c_str(), stdout);
    return 0;
  };
  try {
    app.parse(argc - 1, argv + 1);
  } catch (const CLI::CallForHelp&) {
    return print_help(HelpLevel::common);
  } catch (const CLI::CallForAllHelp&) {
    return print_help(HelpLevel::all);
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::usage, first_line(error.what()));
  }
  if (!app.remaining().empty()) refuse_extra(subcommand, app.remaining());
  if (answers(subcommand, added)) return 0;
  take_values(subcommand, added);
  return subcommand.run();
}

const Subcommand& choose(std::span<const Subcommand> subcommands, const std::string& word) {
  std::vector<std::string> names{"--help", "--version"};
  for (const Subcommand& each : subcommands) {
    if (each.name == word) return each;
    names.push_back(each.name);
  }
  const std::string hint = did_you_mean(word, names);
  throw Error(ErrorCode::usage, concat(word.starts_with("-") ? "unknown option " : "no subcommand ", word),
              hint.empty() ? "`rhoray --help` lists the subcommands" : hint);
}

}  // namespace

std::string error_lines(const std::string& place, const std::string& fact, const std::string& hint) {
  std::string lines = concat(place, ": ", fact, "\n");
  if (!hint.empty()) lines += concat("hint: ", hint, "\n");
  return lines;
}

int run_command_line(std::span<const Subcommand> subcommands, int argc, const char* const* argv) {
  const DefaultFloatingPoint default_floating_point;  // a library that was loaded may have set another
  std::string place = "rhoray";
  const auto fail = [&](ErrorCode error_code, const std::string& fact, const std::string& hint = {}) {
    try {
      require_no_lost_bytes();  // the reason for whatever came of it
    } catch (const Error& loss) {
      std::fputs(error_lines(place, loss.what(), loss.hint()).c_str(), stderr);
      return static_cast<int>(loss.code());
    }
    std::fputs(error_lines(place, fact, hint).c_str(), stderr);
    return error_code == ErrorCode::interrupted ? interrupted_exit_code() : static_cast<int>(error_code);
  };
  try {
    const std::string word = argc > 1 ? argv[1] : "";
    if (word.empty()) return fail(ErrorCode::usage, "no subcommand given", "`rhoray --help` lists them");
    // That standard output takes them is seen at its end (interrupt.h).
    if (word == "--help" || word == "-h" || word == "--help-all")
      return std::fputs(overview(subcommands, help_width()).c_str(), stdout), 0;
    if (word == "--version") return std::puts(version_line().c_str()), 0;
    const Subcommand& subcommand = choose(subcommands, word);
    place += " " + subcommand.name;
    const int exit_code = run_subcommand(subcommand, argc, argv);
    require_no_lost_bytes();
    return exit_code;
  } catch (const Error& error) {
    return fail(error.code(), error.what(), error.hint());
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::resource, "out of memory");
  } catch (const std::exception& error) {
    return fail(ErrorCode::internal, concat("internal error: ", error.what()));
  }
}

}  // namespace rhoray::tools
