#include "formats/base/read_value.h"

#include <array>
#include <charconv>
#include <cmath>

#include "formats/base/error.h"

namespace rhoray {

namespace {

template <class T>
std::optional<T> number_in(std::string_view text) {
  T value{};
  const auto [end, error_code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error_code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <class T>
void read_integer(const std::string& text, T& out, std::string_view expected) {
  const std::optional<T> value = number_in<T>(text);
  if (!value) refuse_value(text, expected);
  out = *value;
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

}  // namespace

std::optional<double> finite_number(std::string_view text) {
  const std::optional<double> value = number_in<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<int> whole_number(std::string_view text) {
  return number_in<int>(text);
}

void refuse_value(const std::string& text, std::string_view expected, const std::string& hint) {
  throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected), hint);
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

void read_value(const std::string& text, std::string& out) {
  if (text.empty()) refuse_value(text, "a string");
  out = text;
}

void read_value(const std::string& text, std::filesystem::path& out) {
  if (text.empty()) refuse_value(text, "a file name");
  out = text;
}

void read_value(const std::string& text, double& out) {
  const std::optional<double> value = finite_number(text);
  if (!value) refuse_value(text, "a finite number");
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
  if (!values) refuse_value(text, "three finite numbers x,y,z");
  out = {(*values)[0], (*values)[1], (*values)[2]};
}

void read_value(const std::string& text, Interval<double>& out) {
  const auto values = numbers<2>(text);
  if (!values || !((*values)[0] < (*values)[1])) refuse_value(text, "two finite numbers a,b with a below b");
  out = {(*values)[0], (*values)[1]};
}

void read_value(const std::string& text, std::vector<std::string>& out) {
  std::vector<std::string> parts = split(text, ',');
  for (const std::string& part : parts)
    if (part.empty()) refuse_value(text, "names separated by commas");
  out = std::move(parts);
}

void require_within(const std::string& name, double value, double lo, double hi) {
  if (!(value >= lo && value <= hi))
    throw Error(ErrorCode::usage, concat(name, ": found ", value, "; expected a number from ", lo, " to ", hi));
}

}  // namespace rhoray
