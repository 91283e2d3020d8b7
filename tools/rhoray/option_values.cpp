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

namespace {

constexpr const char* positional_group = "Input";

[[noreturn]] void refuse(const std::string& text, std::string_view expected, const std::string& hint = {}) {
  throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected), hint);
}

/// The number that fills the whole text, or nothing.
template <class T>
std::optional<T> whole_number(std::string_view text) {
  T value{};
  const auto [end, error_code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error_code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <class T>
void read_integer(const std::string& text, T& out, std::string_view expected) {
  const std::optional<T> value = whole_number<T>(text);
  if (!value) refuse(text, expected);
  out = *value;
}

std::optional<double> finite_number(std::string_view text) {
  const std::optional<double> value = whole_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char letter : text) {
    if (letter == separator)
      parts.emplace_back();
    else
      parts.back() += letter;
  }
  return parts;
}

/// As many finite numbers as asked for, separated by commas, or nothing.
template <std::size_t count>
std::optional<std::array<double, count>> numbers(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != count) return std::nullopt;
  std::array<double, count> values{};
  for (std::size_t i = 0; i < count; ++i) {
    const std::optional<double> value = finite_number(parts[i]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

/// sRGB (IEC 61966-2-1) to linear, both in [0, 1].
double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

std::optional<double> srgb_byte(std::string_view two_digits) {
  unsigned value = 0;
  const auto [end, error_code] = std::from_chars(two_digits.data(), two_digits.data() + 2, value, 16);
  if (error_code != std::errc{} || end != two_digits.data() + 2) return std::nullopt;
  return linear_from_srgb(value / 255.0);
}

}  // namespace

void read_value(const std::string& text, std::string& out) {
  if (text.empty()) refuse(text, "a string");
  out = text;
}

void read_value(const std::string& text, std::filesystem::path& out) {
  if (text.empty()) refuse(text, "a file name");
  out = text;
}

void read_value(const std::string& text, double& out) {
  const std::optional<double> value = finite_number(text);
  if (!value) refuse(text, "a finite number");
  out = *value;
}

void read_value(const std::string& text, std::int64_t& out) {
  read_integer(text, out, "a whole number");
}
void read_value(const std::string& text, std::uint64_t& out) {
  read_integer(text, out, "a whole number from 0");
}
void read_value(const std::string& text, unsigned& out) {
  read_integer(text, out, "a whole number from 0");
}
void read_value(const std::string& text, int& out) {
  read_integer(text, out, "a whole number");
}

void read_value(const std::string& text, Vec3& out) {
  const auto values = numbers<3>(text);
  if (!values) refuse(text, "three finite numbers x,y,z");
  out = {(*values)[0], (*values)[1], (*values)[2]};
}

void read_value(const std::string& text, Interval<double>& out) {
  const auto values = numbers<2>(text);
  if (!values || !((*values)[0] < (*values)[1])) refuse(text, "two finite numbers a,b with a below b");
  out = {(*values)[0], (*values)[1]};
}

void read_value(const std::string& text, PictureSize& out) {
  static constexpr std::pair<std::string_view, PictureSize> names[] = {
      {"720p", {1280, 720}}, {"1080p", {1920, 1080}}, {"4k", {3840, 2160}}};
  for (const auto& [name, size] : names)
    if (text == name) {
      out = size;
      return;
    }
  constexpr int largest_side = 65'536;
  const std::vector<std::string> sides = split(text, 'x');
  const auto side = [&](std::size_t i) { return whole_number<int>(sides[i]).value_or(0); };
  if (sides.size() != 2 || side(0) < 1 || side(1) < 1 || side(0) > largest_side || side(1) > largest_side)
    refuse(text, "WxH with sides from 1 to 65536, or 720p, 1080p, 4k");
  out = {side(0), side(1)};
}

void read_value(const std::string& text, Color& out) {
  if (text.size() == 7 && text[0] == '#') {
    const std::string_view digits(text);
    const auto r = srgb_byte(digits.substr(1, 2)), g = srgb_byte(digits.substr(3, 2)),
               b = srgb_byte(digits.substr(5, 2));
    if (r && g && b) {
      out.linear = {*r, *g, *b};
      return;
    }
  }
  const auto values = numbers<3>(text);
  bool usable = values.has_value();
  if (usable)
    for (const double value : *values) usable = usable && value >= 0 && value <= 1;
  if (!usable) refuse(text, "a colour: #rrggbb, or r,g,b (linear) from 0 to 1");
  out.linear = {(*values)[0], (*values)[1], (*values)[2]};
}

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
    refuse(text, "a number of bytes, such as 2G or 512M");
  out.bytes = static_cast<std::uint64_t>(*value * unit);
}

void read_value(const std::string& text, formats::ElementType& out) {
  using enum formats::ElementType;
  static const std::pair<std::string, formats::ElementType> names[] = {
      {"U8", U8},      {"I8", I8},       {"U16", U16},     {"I16", I16},   {"U32", U32},    {"I32", I32},
      {"U64", U64},    {"I64", I64},     {"F32", F32},     {"F64", F64},   {"uint8", U8},   {"int8", I8},
      {"uint16", U16}, {"int16", I16},   {"uint32", U32},  {"int32", I32}, {"uint64", U64}, {"int64", I64},
      {"float", F32},  {"float32", F32}, {"float64", F64}, {"double", F64}};
  for (const auto& [name, type] : names)
    if (text == name) {
      out = type;
      return;
    }
  refuse(text, "a type: U8, I8, U16, I16, U32, I32, F32 or F64");
}

void read_value(const std::string& text, std::vector<std::string>& out) {
  std::vector<std::string> parts = split(text, ',');
  for (const std::string& part : parts)
    if (part.empty()) refuse(text, "names separated by commas");
  out = std::move(parts);
}

Option number_option(std::string names, std::string value, std::string help, const Interval<double>& limits,
                     std::optional<double>& out) {
  return {Option::Kind::value, std::move(names), std::move(value), std::move(help),
          [&out, limits](const std::string& text) {
            double number = 0;
            read_value(text, number);
            if (!limits.contains(number)) refuse(text, concat("a number from ", limits.lo, " to ", limits.hi));
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
               refuse(text, list, did_you_mean(text, words));
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

void require_within(const std::string& option, double value, double lo, double hi) {
  if (!(value >= lo && value <= hi))
    throw Error(ErrorCode::usage, concat(option, ": found ", value, "; expected a number from ", lo, " to ", hi));
}

}  // namespace rhoray::tools
