#include "tools/rhoray/cli/command_line.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/library_text.h"
#include "formats/base/mapped_file.h"
#include "formats/base/printable.h"
#include "formats/base/word_list.h"
#include "render/load.h"
#include "tools/rhoray/cli/completion.h"
#include "tools/rhoray/cli/given_words.h"
#include "tools/rhoray/cli/help.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/synonyms.h"
#include "tools/rhoray/cli/version.h"

namespace rhoray::tools {

namespace {

/// Those whose value ends in dots take one value each time that they are given.
bool may_be_repeated(const Option& row) {
  return row.kind == Option::Kind::value && row.value.ends_with("...");
}

std::string text_of(const Subcommand& subcommand, const GivenWord& given) {
  const std::string name = long_name(subcommand.options[given.row]);
  return given.text.empty() ? name : concat(name, " ", given.text);
}

/// Whether the later of two options replaces the earlier one.
/// @param changes  the later one was given before with another value
bool replaces(const Subcommand& subcommand, const GivenWord& later, const GivenWord& earlier, bool changes) {
  const Option& row = subcommand.options[later.row];
  if (later.row == earlier.row) return row.kind == Option::Kind::value && !may_be_repeated(row);
  const std::string earlier_name = long_name(subcommand.options[earlier.row]);
  return std::any_of(row.replaces.begin(), row.replaces.end(), [&](const Option::Replaces& which) {
    return (which.value.empty() || which.value == later.text) && (changes || !which.only_after_another) &&
           std::find(which.names.begin(), which.names.end(), earlier_name) != which.names.end();
  });
}

/// Removes the options that a later one replaces, and prints which.
std::vector<GivenWord> without_replaced(const Subcommand& subcommand, const std::vector<GivenWord>& given) {
  std::vector<GivenWord> kept;
  std::vector<std::string> replaced;
  for (const GivenWord& later : given) {
    const bool changes = std::any_of(kept.begin(), kept.end(), [&](const GivenWord& earlier) {
      return earlier.row == later.row && earlier.text != later.text;
    });
    std::erase_if(kept, [&](const GivenWord& earlier) {
      if (!replaces(subcommand, later, earlier, changes)) return false;
      if (earlier.row != later.row || earlier.text != later.text)
        replaced.push_back(concat(text_of(subcommand, later), " replaces ", text_of(subcommand, earlier)));
      return true;
    });
    kept.push_back(later);
  }
  const bool is_quiet = std::any_of(kept.begin(), kept.end(), [&](const GivenWord& one) {
    return long_name(subcommand.options[one.row]) == "--quiet";
  });
  if (!replaced.empty() && !is_quiet) std::fputs(concat("note: ", joined(replaced, "; "), "\n").c_str(), stderr);
  return kept;
}

/// Passes the given values to the rows, in the order of the rows; errors get the option's name as
/// prefix.
void take_values(const Subcommand& subcommand, std::vector<GivenWord> given) {
  for (const Option& row : subcommand.options) {
    const bool is_given = std::any_of(given.begin(), given.end(),
                                      [&](const GivenWord& one) { return &subcommand.options[one.row] == &row; });
    if (is_positional(row) && !is_given)
      throw Error(ErrorCode::usage, concat("no ", row.names, " given"),
                  concat("`rhoray ", subcommand.name, " --help` starts with examples"));
  }
  std::stable_sort(given.begin(), given.end(), [](const GivenWord& a, const GivenWord& b) { return a.row < b.row; });
  for (const GivenWord& one : given) try {
      subcommand.options[one.row].take(one.text);
    } catch (const Error& error) {
      throw Error(error.code(), concat(long_name(subcommand.options[one.row]), ": ", error.what()), error.hint());
    }
}

/// The help that was asked for, or nothing.
std::optional<HelpLevel> wanted_help(std::span<const Option> rows, const std::vector<GivenWord>& given) {
  for (const GivenWord& one : given) {
    if (long_name(rows[one.row]) == "--help") return HelpLevel::common;
    if (long_name(rows[one.row]) == "--help-all") return HelpLevel::all;
  }
  return std::nullopt;
}

int run_subcommand(const Subcommand& subcommand, std::span<const char* const> words) {
  const std::vector<Option> rows = rows_with_help(subcommand);
  const std::vector<GivenWord> given = given_words(subcommand.name, rows, words);
  if (const std::optional<HelpLevel> level = wanted_help(rows, given)) {
    std::fputs(help_text(subcommand, *level, help_width()).c_str(), stdout);
    return 0;
  }
  for (const GivenWord& one : given)
    if (rows[one.row].kind == Option::Kind::answer) {
      rows[one.row].take({});
      return 0;
    }
  take_values(subcommand, without_replaced(subcommand, given));
  return subcommand.run();
}

const Subcommand& choose(std::span<const Subcommand> subcommands, const std::string& word) {
  std::vector<std::string> names{"help", "--help", "--version"};
  for (const Subcommand& each : subcommands) {
    if (each.name == word) return each;
    names.push_back(each.name);
  }
  const std::string hint = subcommand_hint(word, names);
  throw Error(ErrorCode::usage, concat(word.starts_with("-") ? "unknown option " : "no subcommand ", word),
              hint.empty() ? "`rhoray --help` lists the subcommands" : hint);
}

/// `rhoray help SUBCOMMAND`.
int print_help(std::span<const Subcommand> subcommands, std::span<const char* const> words) {
  if (words.size() > 1)
    throw Error(ErrorCode::usage, concat("unexpected ", words[1]), "`rhoray help SUBCOMMAND` takes one subcommand");
  const std::string text = words.empty() ? overview(subcommands, help_width())
                                         : help_text(choose(subcommands, words[0]), HelpLevel::common, help_width());
  return std::fputs(text.c_str(), stdout), 0;
}

int print_version(std::span<const char* const> words) {
  if (!words.empty()) throw Error(ErrorCode::usage, concat("unexpected ", words[0]), "`rhoray --version` stands alone");
  return std::puts(version_line().c_str()), 0;
}

/// Fields that a shell offers. Only packed files are read quickly enough.
std::vector<std::string> fields_of_packed_file(const std::filesystem::path& path) try {
  if (path.extension() != ".rho") return {};
  return render::Dataset::load(path).color_names();
} catch (const std::exception&) {  // a shell shows no reasons
  return {};
}

/// `rhoray complete WORD...`, which the completions of shells call.
int print_completion(std::span<const Subcommand> subcommands, std::span<const char* const> words) {
  const std::vector<std::string> texts(words.begin(), words.end());
  return std::fputs(text_of(completion_of(subcommands, texts, fields_of_packed_file)).c_str(), stdout), 0;
}

}  // namespace

std::string error_lines(const std::string& place, const std::string& fact, const std::string& hint) {
  std::string lines = concat(place, ": ", printable(fact), "\n");
  if (!hint.empty()) lines += concat("hint: ", printable(hint), "\n");
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
    const auto words = std::span(argv, static_cast<std::size_t>(argc)).subspan(2);
    if (word == "help") return print_help(subcommands, words);
    if (word == "complete") return print_completion(subcommands, words);
    if (word == "--version") return print_version(words);
    const Subcommand& subcommand = choose(subcommands, word);
    place += " " + subcommand.name;
    const int exit_code = run_subcommand(subcommand, words);
    require_no_lost_bytes();
    return exit_code;
  } catch (const Error& error) {
    return fail(error.code(), error.what(), error.hint());
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::resource, "out of memory");
  } catch (const std::length_error& error) {  // an array larger than any memory
    note_library_text(error.what());
    return fail(ErrorCode::resource, "out of memory");
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ErrorCode::unreadable, concat(error.path1().string(), ": ", error.code().message()));
  } catch (const std::exception& error) {
    return fail(ErrorCode::internal, concat("internal error: ", error.what()));
  }
}

}  // namespace rhoray::tools
