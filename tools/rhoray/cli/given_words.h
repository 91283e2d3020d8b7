#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// An option or a positional argument as it was given.
struct GivenWord {
  std::size_t row;   ///< of the rows of options
  std::string text;  ///< empty for an option without a value
};

/// Splits the words behind a subcommand by its rows, in the order of the command line. Values are
/// given as `--name VALUE`, `--name=VALUE`, `-n VALUE`, `-nVALUE` or `-n=VALUE`; options of one
/// letter without values may share a dash. Behind `--`, every word is a positional argument.
///
/// A separate value never begins with two dashes and is never the name of an option. So an option
/// whose value was forgotten does not take the next option for it. A parser library did, and its
/// messages were its own.
///
/// Refuses an unknown option and names the one that was probably meant, an option without its
/// value, a value of an option that takes none, and one positional argument too many
/// (ErrorCode::usage).
std::vector<GivenWord> given_words(const std::string& subcommand, std::span<const Option> rows,
                                   std::span<const char* const> words);

/// "--output" of "-o,--output".
std::string long_name(const Option& row);

/// "-o" of "-o,--output"; empty without one.
std::string short_name(const Option& row);

/// The option with this short or long name, or nullptr.
const Option* option_named(std::span<const Option> rows, std::string_view name);

/// Whether the row is a flag or an answer.
bool takes_no_value(const Option& row);

/// Whether the row is a positional argument.
bool is_positional(const Option& row);

}  // namespace rhoray::tools
