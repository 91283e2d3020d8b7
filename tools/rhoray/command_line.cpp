#include "tools/rhoray/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/mapped_file.h"
#include "formats/base/nearest_name.h"
#include "tools/rhoray/interrupt.h"
#include "tools/rhoray/version.h"

namespace rhoray::tools {

namespace {

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

std::string overview(std::span<const Subcommand> subcommands) {
  std::string text =
      "Ray tracing of volumes and tetrahedral meshes.\n"
      "Usage: rhoray SUBCOMMAND [OPTIONS] FILE...\n"
      "\n"
      "Subcommands:\n";
  for (const Subcommand& each : subcommands)
    text += concat("  ", each.name, std::string(each.name.size() < 16 ? 16 - each.name.size() : 1, ' '), each.summary,
                   "\n");
  text +=
      "\n"
      "Options:\n"
      "  --help          print this text; `rhoray SUBCOMMAND --help` describes one subcommand\n"
      "  --version       print version, commit and compiler\n"
      "\n"
      "Limits:\n"
      "  Foreign files are read, and TetGen and CGAL run, in worker processes with limits:\n"
      "  memory          --memory; default 8 GiB plus 1024 times the size of the input file, at most 90 % of the\n"
      "                  memory of the machine or of the control group; 90 % if one input names other files\n"
      "  files           256 open; each at most as large as the worker's memory, or as the output it must write\n"
      "  idle time       60 s without CPU time, reading or writing\n"
      "  Inputs must be files or folders; pipes and devices are refused.\n"
      "\n"
      "Exit codes: 0 success, 1 internal error, 2 wrong usage, 3 input missing or unreadable, 4 input invalid or\n"
      "damaged, 5 out of memory, disk or time, 6 comparison outside its limit, 7 unknown file type or version;\n"
      "130, 143, 129 ended by SIGINT, SIGTERM, SIGHUP; 141 the reader of a pipe has gone\n"
      "\n"
      "Example:\n"
      "  rhoray pack head.nrrd -o head.rho && rhoray render head.rho -o head.png\n";
  return text;
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
  std::vector<std::string> names{"--help"};
  for (const Option& row : subcommand.options)
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
                  concat("`rhoray ", subcommand.name, " --help` ends with an example"));
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
  app.footer("Example:\n" + subcommand.examples);
  const std::vector<CLI::Option*> added = add_options(app, subcommand);
  try {
    app.parse(argc - 1, argv + 1);
  } catch (const CLI::CallForHelp&) {
    for (CLI::Option* option : added)
      if (option->get_positional()) option->required();  // shown without brackets; while parsing, we check that
    std::fputs(app.help().c_str(), stdout);
    return 0;
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
    // That standard output takes them is seen at its end (standard_streams.h).
    if (word == "--help" || word == "-h") return std::fputs(overview(subcommands).c_str(), stdout), 0;
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
