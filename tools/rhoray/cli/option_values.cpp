#include "tools/rhoray/cli/option_values.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"

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

Option number_option(std::string names, std::string value, std::string help, const Interval<double>& limits,
                     std::optional<double>& out) {
  return {Option::Kind::value, std::move(names), std::move(value), std::move(help),
          [&out, limits](const std::string& text) {
            double number = 0;
            read_value(text, number);
            if (!limits.contains(number)) refuse_value(text, concat("a number from ", limits.lo, " to ", limits.hi));
            out = number;
          }};
}

Option choice_option(std::string names, std::vector<std::string> words, std::string help, std::string& out) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : "|") + word;
  Option row{Option::Kind::value, std::move(names), list, std::move(help),
             [&out, words, list](const std::string& text) {
               for (const std::string& word : words)
                 if (text == word) {
                   out = text;
                   return;
                 }
               refuse_value(text, list, did_you_mean(text, words));
             }};
  row.choices = std::move(words);
  return row;
}

Option flag_option(std::string names, std::string help, bool& out) {
  return {Option::Kind::flag, std::move(names), "", std::move(help), [&out](const std::string&) { out = true; }};
}

Option answer_option(std::string names, std::string help, std::string (*text)()) {
  return {Option::Kind::answer, std::move(names), "", std::move(help), [text](const std::string&) {
            std::fputs(text().c_str(), stdout);  // standard_streams.h tells when it was not taken
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

}  // namespace rhoray::tools
