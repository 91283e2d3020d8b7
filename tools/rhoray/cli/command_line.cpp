#include "tools/rhoray/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <new>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/mapped_file.h"
#include "formats/base/word_list.h"
#include "tools/rhoray/cli/help.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/synonyms.h"
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
      added.push_back(app.add_flag(row.names, row.help)->disable_flag_override());
      continue;
    }
    CLI::Option* option = app.add_option(row.names, taken_later, row.help);
    option->type_name(row.value);
    if (row.kind == Option::Kind::file)
      option->expected(1);
    else
      option->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args(row.kind == Option::Kind::files);
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
      const std::string hint = option_hint(name, long_names(subcommand));
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

bool is_positional(const Option& row) {
  return row.kind == Option::Kind::file || row.kind == Option::Kind::files;
}

/// "--output" of "-o,--output".
std::string long_name(const Option& row) {
  return row.names.substr(row.names.find(',') + 1);
}

/// An option as it was given.
struct Given {
  std::size_t row;
  std::string text;  ///< empty for one without a value
};

std::string text_of(const Subcommand& subcommand, const Given& given) {
  const std::string name = long_name(subcommand.options[given.row]);
  return given.text.empty() ? name : concat(name, " ", given.text);
}

/// All that was given, in the order of the command line.
std::vector<Given> given_in_order(const CLI::App& app, const Subcommand& subcommand,
                                  std::span<CLI::Option* const> added) {
  std::vector<std::size_t> taken(added.size(), 0);
  std::vector<Given> all;
  for (const CLI::Option* option : app.parse_order()) {
    const auto row = static_cast<std::size_t>(std::find(added.begin(), added.end(), option) - added.begin());
    if (row == added.size() || taken[row] == option->results().size()) continue;
    const std::string& text = option->results()[taken[row]++];
    all.push_back({row, takes_no_value(subcommand.options[row]) ? std::string() : text});
  }
  return all;
}

/// Whether the later of two options replaces the earlier one.
/// @param changes  the later one was given before with another value
bool replaces(const Subcommand& subcommand, const Given& later, const Given& earlier, bool changes) {
  const Option& row = subcommand.options[later.row];
  if (later.row == earlier.row) return row.kind == Option::Kind::value && !may_be_repeated(row);
  const std::string earlier_name = long_name(subcommand.options[earlier.row]);
  return std::any_of(row.replaces.begin(), row.replaces.end(), [&](const Option::Replaces& which) {
    return (which.value.empty() || which.value == later.text) && (changes || !which.only_after_another) &&
           std::find(which.names.begin(), which.names.end(), earlier_name) != which.names.end();
  });
}

/// Removes the options that a later one replaces, and prints which.
std::vector<Given> without_replaced(const Subcommand& subcommand, const std::vector<Given>& given) {
  std::vector<Given> kept;
  std::vector<std::string> replaced;
  for (const Given& later : given) {
    const bool changes = std::any_of(kept.begin(), kept.end(), [&](const Given& earlier) {
      return earlier.row == later.row && earlier.text != later.text;
    });
    std::erase_if(kept, [&](const Given& earlier) {
      if (!replaces(subcommand, later, earlier, changes)) return false;
      if (earlier.row != later.row || earlier.text != later.text)
        replaced.push_back(concat(text_of(subcommand, later), " replaces ", text_of(subcommand, earlier)));
      return true;
    });
    kept.push_back(later);
  }
  const bool is_quiet = std::any_of(
      kept.begin(), kept.end(), [&](const Given& one) { return long_name(subcommand.options[one.row]) == "--quiet"; });
  if (!replaced.empty() && !is_quiet) std::fputs(concat("note: ", joined(replaced, "; "), "\n").c_str(), stderr);
  return kept;
}

/// Passes the given values to the rows, in the order of the rows; errors get the option's name as
/// prefix.
void take_values(const Subcommand& subcommand, std::vector<Given> given) {
  for (const Option& row : subcommand.options) {
    const bool is_given =
        std::any_of(given.begin(), given.end(), [&](const Given& one) { return &subcommand.options[one.row] == &row; });
    if (is_positional(row) && !is_given)
      throw Error(ErrorCode::usage, concat("no ", row.names, " given"),
                  concat("`rhoray ", subcommand.name, " --help` starts with examples"));
  }
  std::stable_sort(given.begin(), given.end(), [](const Given& a, const Given& b) { return a.row < b.row; });
  for (const Given& one : given) try {
      subcommand.options[one.row].take(one.text);
    } catch (const Error& error) {
      throw Error(error.code(), concat(long_name(subcommand.options[one.row]), ": ", error.what()), error.hint());
    }
}

/// Refuses a value of an option that takes none: --quiet=3.
void refuse_values_of_flags(const Subcommand& subcommand, std::span<const char* const> words) {
  for (const std::string word : words)
    for (const Option& row : subcommand.options)
      if (takes_no_value(row) && word.starts_with(concat(long_name(row), "=")))
        throw Error(ErrorCode::usage, concat(long_name(row), ": takes no value; found '", word, "'"));
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
  } catch (const CLI::ArgumentMismatch& error) {
    refuse_values_of_flags(subcommand, {argv, static_cast<std::size_t>(argc)});
    throw Error(ErrorCode::usage, first_line(error.what()));
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::usage, first_line(error.what()));
  }
  if (!app.remaining().empty()) refuse_extra(subcommand, app.remaining());
  if (answers(subcommand, added)) return 0;
  take_values(subcommand, without_replaced(subcommand, given_in_order(app, subcommand, added)));
  return subcommand.run();
}

const Subcommand& choose(std::span<const Subcommand> subcommands, const std::string& word) {
  std::vector<std::string> names{"--help", "--version"};
  for (const Subcommand& each : subcommands) {
    if (each.name == word) return each;
    names.push_back(each.name);
  }
  const std::string hint = subcommand_hint(word, names);
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
