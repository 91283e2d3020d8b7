#include "formats/base/number_text.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "formats/base/text.h"

namespace rhoray {

namespace {

double value_of(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

}  // namespace

std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3;) {
    at -= 3;
    text.insert(at, ",");
  }
  return text;
}

std::string counted(std::uint64_t number, const std::string& singular, const std::string& plural) {
  return concat(grouped(number), " ", number == 1 ? singular : plural);
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 1024) return concat(bytes, " B");
  static constexpr std::string_view units[] = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  double value = static_cast<double>(bytes) / 1024;
  std::size_t unit = 0;
  for (; value >= 1024; ++unit) value /= 1024;
  char text[32];
  std::snprintf(text, sizeof text, "%.1f ", value);
  return concat(text, units[unit]);
}

std::string rounded(double number, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*g", digits, number);
  return text;
}

std::string rounded_up(double number, int digits) {
  std::string text = rounded(number, digits);
  // A step beyond half a unit of the last digit rounds to the next text.
  const double step = std::abs(number) * 0.6 * std::pow(10, 1 - digits);
  if (value_of(text) < number) text = rounded(number + step, digits);
  return text;
}

int digits_for(double number, double error) {
  int digits = 4;
  while (digits < 17 && std::abs(value_of(rounded(number, digits)) - number) > error / 16) ++digits;
  return digits;
}

std::string rounded_within(double extent, double number, int digits) {
  const int needed = extent > 0 ? digits_for(number, 16e-4 * extent) : digits;
  if (needed <= digits) return rounded(number, digits);
  const int whole = static_cast<int>(std::floor(std::log10(std::abs(number)))) + 1;
  return rounded(number, whole <= 15 ? std::max(needed, whole) : needed);  // without a power of ten
}

std::string text_with_error(double number, double error, const std::string& unit) {
  const std::string text = rounded(number, digits_for(number, error)), after = unit.empty() ? "" : " " + unit;
  const double of_text = std::abs(value_of(text) - number);
  return concat(text, after, ", error at most ", rounded_up(error + of_text, 2), after);
}

}  // namespace rhoray
