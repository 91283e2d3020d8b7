#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// How much of a subcommand's help is printed.
enum class HelpLevel {
  common,  ///< --help: without options for experts, details and further examples
  all      ///< --help-all
};

/// The rows of a subcommand as the help lists them: those of --help and --help-all are the last.
std::vector<Option> rows_with_help(const Subcommand& subcommand);

/// The columns for help: COLUMNS of the environment, else those of the terminal on stdout, else 80.
/// At least 60 and at most 100.
std::size_t help_width();

// All lines have at most `width` columns and end with a line feed.

/// The help of a subcommand: summary, usage, examples, then positional arguments and options by
/// group.
std::string help_text(const Subcommand& subcommand, HelpLevel level, std::size_t width);

/// The help of the program in sections: subcommands by group, options, limits, exit codes,
/// environment.
std::vector<HelpSection> sections_of_program(std::span<const Subcommand> subcommands);

/// The help of the program.
std::string overview(std::span<const Subcommand> subcommands, std::size_t width);

/// A heading and its entries. The texts start in one column. A term that reaches into it has a line
/// of its own.
std::string section_text(const HelpSection& section, std::size_t width);

/// A command line; a longer one is continued in further lines, as a shell reads them. An option
/// stays with its value.
std::string example_text(std::string_view command, std::size_t width);

/// The words of a text in lines of at most `width` columns; a longer word is cut, behind a "|" if
/// it has one there. A percent sign stays with its number.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);

}  // namespace rhoray::tools
