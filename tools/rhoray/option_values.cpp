#include "tools/rhoray/option_values.h"

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
  return {Option::Kind::value, std::move(names), list, std::move(help), [&out, words, list](const std::string& text) {
            for (const std::string& word : words)
              if (text == word) {
                out = text;
                return;
              }
            refuse_value(text, list, did_you_mean(text, words));
          }};
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
  return {Option::Kind::file, std::move(name), "", std::move(help),
          [&out](const std::string& text) { read_value(text, out); }};
}

Option files_option(std::string name, std::string help, std::vector<std::filesystem::path>& out) {
  return {Option::Kind::files, std::move(name), "", std::move(help),
          [&out](const std::string& text) { read_value(text, out.emplace_back()); }};
}

}  // namespace rhoray::tools
