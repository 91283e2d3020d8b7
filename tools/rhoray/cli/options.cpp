#include "tools/rhoray/cli/options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/library_text.h"
#include "formats/base/nearest_name.h"
#include "formats/base/printable.h"
#include "formats/base/word_list.h"

namespace rhoray::tools {

namespace {

constexpr const char* positional_group = "Input";

}  // namespace

void read_value(const std::string& text, ByteCount& out) {
  static constexpr std::string_view suffixes = "KMGT";
  std::string_view digits(text);
  double unit = 1;
  if (!digits.empty())
    if (const std::size_t at = suffixes.find(digits.back()); at != std::string_view::npos) {
      unit = std::ldexp(1.0, 10 * (static_cast<int>(at) + 1));
      digits.remove_suffix(1);
    }
  const std::optional<double> value = finite_number(digits);
  constexpr double largest = 9.2e18;  // keeps the conversion below within 64 bits
  if (!value || !(*value * unit >= 1) || !(*value * unit <= largest))
    refuse_value(text, "a number of bytes, such as 2G or 512M");
  out.bytes = static_cast<std::uint64_t>(*value * unit);
}

Option choice_option(std::string names, std::vector<std::string> words, std::string help,
                     std::function<void(const std::string&)> take) {
  const std::string list = joined(words, "|");
  Option row{Option::Kind::value, std::move(names), list, std::move(help),
             [words, list, take = std::move(take)](const std::string& text) {
               if (std::find(words.begin(), words.end(), text) == words.end())
                 refuse_value(text, list, did_you_mean(text, words));
               take(text);
             }};
  row.choices = std::move(words);
  return row;
}

Option flag_option(std::string names, std::string help, bool& out) {
  return {Option::Kind::flag, std::move(names), "", std::move(help), [&out](const std::string&) { out = true; }};
}

Option answer_option(std::string names, std::string help, std::string (*text)()) {
  return {Option::Kind::answer, std::move(names), "", std::move(help), [text](const std::string&) {
            std::fputs(text().c_str(), stdout);  // interrupt.h tells when it was not taken
          }};
}

Option file_option(std::string name, std::string help, std::filesystem::path& out) {
  Option row{Option::Kind::file, std::move(name), "", std::move(help),
             [&out](const std::string& text) { read_value(text, out); }};
  row.group = positional_group;
  return row;
}

Option files_option(std::string name, std::string help, std::vector<std::filesystem::path>& out) {
  Option row{Option::Kind::files, std::move(name), "", std::move(help),
             [&out](const std::string& text) { read_value(text, out.emplace_back()); }};
  row.group = positional_group;
  return row;
}

std::vector<Option> in_group(const std::string& group, std::vector<Option> rows) {
  for (Option& row : rows) row.group = group;
  return rows;
}

Option with_details(Option row, std::string details) {
  row.details = std::move(details);
  return row;
}

Option for_experts(Option row) {
  row.is_expert = true;
  return row;
}

std::vector<Option> for_experts(std::vector<Option> rows) {
  for (Option& row : rows) row.is_expert = true;
  return rows;
}

std::vector<Option> output_options(CommonOptions& common, const std::string& help, const std::string& value) {
  return {value_option("-o,--output", value, help, common.output),
          flag_option("--force", "Overwrite existing output", common.force)};
}

std::vector<Option> threads_option(CommonOptions& common) {
  return {value_option("--threads", "N", "Number of threads; default 0 (all cores)", common.threads)};
}

Option cache_option(CommonOptions& common) {
  return for_experts(with_details(
      flag_option("--no-cache", "Pack files that are not packed into memory, and keep no packed copy", common.no_cache),
      "`rhoray cache --help` says where packed copies are kept"));
}

Option memory_option(CommonOptions& common, const std::string& help) {
  return value_option("--memory", "SIZE", help, common.memory);
}

Option worker_memory_option(CommonOptions& common, const std::string& worker) {
  return for_experts(
      memory_option(common, concat("Memory limit of ", worker, "; default: see Limits in `rhoray --help`")));
}

std::vector<Option> message_options(CommonOptions& common, const std::string& json_help,
                                    const std::string& verbose_help) {
  return {flag_option("-q,--quiet", "Print errors only", common.quiet),
          with_details({Option::Kind::flag, "-v,--verbose", "", verbose_help,
                        [&common](const std::string&) {
                          common.verbose = true;
                          set_library_text_sink(
                              [&common](const std::string& line) { tell(common, concat("library: ", line)); });
                        }},
                       "Texts of the libraries that read and write files begin with `library:`"),
          for_experts(choice_option("--progress", {"auto", "bar", "plain", "json", "none"},
                                    "Progress on stderr; auto: a bar on a terminal, else none; default auto",
                                    common.progress)),
          flag_option("--json", json_help, common.json)};
}

Option max_error_option(std::optional<double>& max_error) {
  return with_details(
      value_option("--max-error", "E", "Largest error of the tetrahedra that replace a higher-order cell; default 0.01",
                   max_error),
      "The error of the shape is relative to the diagonal of the mesh's box. The error of a kept field "
      "is relative to the field's range");
}

Option time_option(std::string& time) {
  return value_option(
      "--time", "T",
      "Time step: first, last, #N counted from 0, or the nearest to a time; default last, of a volume first", time);
}

std::vector<Option> raw_options(std::string& raw, std::optional<Vec3>& spacing, std::optional<Vec3>& origin) {
  return {value_option("--raw", "WxHxD:TYPE[:le|be][:SKIP]", "Read samples without a header, after SKIP bytes", raw),
          value_option("--spacing", "X,Y,Z", "Replace the file's spacing", spacing),
          value_option("--origin", "X,Y,Z", "Replace the file's origin", origin)};
}

std::vector<Option> all_options(std::initializer_list<std::vector<Option>> lists) {
  std::vector<Option> all;
  for (const std::vector<Option>& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

void say(const CommonOptions& common, const std::string& line) {
  if (!common.quiet) std::fputs((printable(line) + "\n").c_str(), stderr);
}

void tell(const CommonOptions& common, const std::string& line) {
  if (common.verbose) say(common, line);
}

void require_writable(const CommonOptions& common, const std::filesystem::path& output,
                      const std::filesystem::path& input) {
  const std::string name = output.string();
  std::error_code ignored;
  const std::filesystem::path folder = output.has_parent_path() ? output.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, ignored))
    throw Error(ErrorCode::usage, concat(name, ": there is no folder ", folder.string()), "create the folder first");
  if (std::filesystem::is_directory(output, ignored))
    throw Error(ErrorCode::usage, concat(name, ": is a folder; expected a file name"));
  if (std::filesystem::equivalent(output, input, ignored))
    throw Error(ErrorCode::usage, concat(name, ": is the input file; expected another name"));
  if (std::filesystem::exists(output, ignored) && !common.force)
    throw Error(ErrorCode::usage, concat(name, " already exists"), "use --force to overwrite it");
}

std::filesystem::path default_output(const std::filesystem::path& input, const std::string& extension) {
  std::filesystem::path name = std::filesystem::absolute(input).lexically_normal();
  name = name.has_filename() ? name.filename() : name.parent_path().filename();  // a folder may end with a slash
  if (name.extension() == ".gz") name.replace_extension();
  return name.replace_extension(extension);
}

std::string shell_line(const std::vector<std::string>& words) {
  static constexpr std::string_view plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_@%+=:,./-";
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char letter : word) {
      if (letter == '\'')
        line += "'\\''";
      else
        line += letter;
    }
    line += '\'';
  }
  return line;
}

}  // namespace rhoray::tools
