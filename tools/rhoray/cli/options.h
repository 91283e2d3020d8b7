#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/progress.h"
#include "formats/base/read_value.h"
#include "formats/base/text.h"
#include "formats/packed_file.h"
#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// A number of bytes, read from 2G, 512M, 64K, 1.5T or a plain number (1K = 1024).
struct ByteCount {
  std::uint64_t bytes = 0;
};

using rhoray::read_value;  // of numbers, vectors and names
void read_value(const std::string& text, ByteCount& out);

/// A row for an option that takes one value.
template <class T>
Option value_option(std::string names, std::string value, std::string help, T& out) {
  return {Option::Kind::value, std::move(names), std::move(value), std::move(help),
          [&out](const std::string& text) { read_value(text, out); }};
}

/// A row for an option that takes some of the values of its type.
/// @param expected  "a number above 0"
template <class T>
Option value_option_if(std::string names, std::string value, std::string help, std::string expected,
                       std::function<bool(const T&)> is_taken, std::optional<T>& out) {
  return {Option::Kind::value, std::move(names), std::move(value), std::move(help),
          [expected = std::move(expected), is_taken = std::move(is_taken), &out](const std::string& text) {
            T number{};
            read_value(text, number);
            if (!is_taken(number)) refuse_value(text, expected);
            out = number;
          }};
}

/// A row for an option that takes a number within limits.
template <class T>
Option number_option(std::string names, std::string value, std::string help, const Interval<T>& limits,
                     std::optional<T>& out) {
  return value_option_if<T>(
      std::move(names), std::move(value), std::move(help),
      concat(std::integral<T> ? "a whole number from " : "a number from ", limits.lo, " to ", limits.hi),
      [limits](const T& number) { return limits.contains(number); }, out);
}

/// A row for an option that takes one of some words, which become the row's choices.
Option choice_option(std::string names, std::vector<std::string> words, std::string help,
                     std::function<void(const std::string&)> take);
/// @param out  a text, or an optional one
template <class Text>
Option choice_option(std::string names, std::vector<std::string> words, std::string help, Text& out) {
  return choice_option(std::move(names), std::move(words), std::move(help),
                       [&out](const std::string& text) { out = text; });
}

/// A row for an option without a value that stands for one.
template <class T>
Option constant_option(std::string names, std::string help, const T& constant, std::optional<T>& out) {
  return {Option::Kind::flag, std::move(names), "", std::move(help),
          [constant, &out](const std::string&) { out = constant; }};
}

Option flag_option(std::string names, std::string help, bool& out);
/// A row that prints a text to stdout instead of all else.
Option answer_option(std::string names, std::string help, std::string (*text)());
Option file_option(std::string name, std::string help, std::filesystem::path& out);
Option files_option(std::string name, std::string help, std::vector<std::filesystem::path>& out);

// What the help says about rows; see Option.
std::vector<Option> in_group(const std::string& group, std::vector<Option> rows);
Option with_details(Option row, std::string details);
Option for_experts(Option row);
std::vector<Option> for_experts(std::vector<Option> rows);

/// Options shared by subcommands. Each subcommand offers those that apply to it.
struct CommonOptions {
  std::filesystem::path output;  ///< empty when not given
  bool force = false;
  unsigned threads = 0;  ///< 0 = all cores
  ByteCount memory;      ///< 0 = not limited
  bool quiet = false;
  bool verbose = false;
  std::string progress = "auto";
  bool json = false;
  bool no_cache = false;  ///< files that are not packed are packed into memory
};

/// -o, --force
std::vector<Option> output_options(CommonOptions& common, const std::string& help, const std::string& value = "FILE");
std::vector<Option> threads_option(CommonOptions& common);             ///< --threads
Option cache_option(CommonOptions& common);                            ///< --no-cache
Option memory_option(CommonOptions& common, const std::string& help);  ///< --memory
/// --memory of a worker process, for experts.
Option worker_memory_option(CommonOptions& common, const std::string& worker);
/// -q, -v, --progress, --json
std::vector<Option> message_options(CommonOptions& common, const std::string& json_help,
                                    const std::string& verbose_help = "Print more messages");

// Options of `pack` and `import` for meshes.
Option max_error_option(std::optional<double>& max_error);  ///< --max-error
Option time_option(std::string& time);                      ///< --time

/// --raw, --spacing, --origin
std::vector<Option> raw_options(std::string& raw, std::optional<Vec3>& spacing, std::optional<Vec3>& origin);

/// The rows of several lists, in order.
std::vector<Option> all_options(std::initializer_list<std::vector<Option>> lists);

/// Puts a line on stderr, unless quiet.
void say(const CommonOptions& common, const std::string& line);
/// Puts a line on stderr when verbose.
void tell(const CommonOptions& common, const std::string& line);

/// Refuses an output that could not be written at the end of the work: the folder is missing, the
/// name is that of a folder, a file exists and --force is not given, or it is the input
/// (ErrorCode::usage).
void require_writable(const CommonOptions& common, const std::filesystem::path& output,
                      const std::filesystem::path& input);

/// The default path of an output: the input's name with this extension, in the working folder.
std::filesystem::path default_output(const std::filesystem::path& input, const std::string& extension);

/// The words of a command line as a shell would read them.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace rhoray::tools
