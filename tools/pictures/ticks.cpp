#include "tools/pictures/ticks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>

namespace rhoray::tools {

namespace {

/// The power of ten of a number's first digit.
int power_of(double number) {
  return static_cast<int>(std::floor(std::log10(number) + 1e-9));
}

std::string written(double value, double step, double largest) {
  char text[64];
  if (largest >= 1e5 || step < 1e-4) {
    std::snprintf(text, sizeof text, "%.*e", std::max(0, power_of(largest) - power_of(step)), value);
  } else {
    std::snprintf(text, sizeof text, "%.*f", std::max(0, -power_of(step)), value);
  }
  return value == 0 ? "0" : with_minus_signs(text);
}

/// 1, 2, 5, 10, 20, ..., and the same times negative powers of ten.
double next_step(double step) {
  const double power = std::pow(10, power_of(step)), digit = std::round(step / power);
  return (digit < 2 ? 2 : digit < 5 ? 5 : 10) * power;
}

/// A number with some decimals, by a power of ten or not.
std::string decimal_text(double value, int decimals, bool by_power) {
  char text[512];
  std::snprintf(text, sizeof text, by_power ? "%.*e" : "%.*f", decimals, value);
  return text;
}

/// The fewest decimals that tell a value within a slack.
int decimals_within(double value, double slack, bool by_power) {
  int decimals = 0;
  while (decimals < 15 &&
         std::abs(std::strtod(decimal_text(value, decimals, by_power).c_str(), nullptr) - value) > slack)
    ++decimals;
  return decimals;
}

/// How many bands lie between labels: a number that divides all where that leaves enough labels.
std::size_t label_distance(std::size_t band_count, std::size_t most) {
  std::size_t least = 1;
  while (band_count / least + 1 > most) ++least;
  for (std::size_t each = least; each <= 2 * least && each <= band_count; ++each)
    if (band_count % each == 0) return each;
  return least;
}

/// A digit times a power of ten.
struct DecimalNumber {
  int digit, power;

  double value() const { return digit * std::pow(10, power); }
  bool operator==(const DecimalNumber&) const = default;
};

/// 0.02 if plain, else 2×10⁻².
std::string text_of(const DecimalNumber& number, bool is_plain) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", std::max(0, -number.power), number.value());
  if (is_plain) return text;
  static constexpr const char* raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string power = number.digit == 1 ? "10" : std::to_string(number.digit) + "×10";
  if (number.power < 0) power += "⁻";
  for (const char digit : std::to_string(std::abs(number.power))) power += raised[digit - '0'];
  return power;
}

}  // namespace

std::string with_minus_signs(std::string text) {
  for (std::size_t at; (at = text.find('-')) != std::string::npos;) text.replace(at, 1, "\u2212");
  return text;
}

std::vector<Tick> ticks_of(const Interval<double>& range, int most) {
  const double width = range.hi - range.lo;
  const double largest = std::max(std::abs(range.lo), std::abs(range.hi));
  const double slack = 1e-9;  // in steps: range ends that are multiples up to rounding are included
  double step = std::pow(10, std::floor(std::log10(width / std::max(most, 1))) - 1);
  if (!(width > largest * 1e-12) || !(step > 0) || !std::isfinite(step)) {  // the step may overflow or underflow
    char text[64];
    std::snprintf(text, sizeof text, "%.6g", range.lo);
    return {{range.lo, text}};
  }
  const auto first = [&] { return std::ceil(range.lo / step - slack); };
  const auto last = [&] { return std::floor(range.hi / step + slack); };
  while (last() - first() + 1 > std::max(most, 1)) step = next_step(step);
  std::vector<Tick> ticks;
  for (double number = first(); number <= last(); ++number)
    ticks.push_back({number * step, written(number * step, step, largest)});
  return ticks;
}

std::vector<Tick> log_ticks_of(const Interval<double>& range, int most) {
  constexpr double slack = 1e-9;
  const int first = static_cast<int>(std::floor(std::log10(range.lo) + slack)),
            last = static_cast<int>(std::floor(std::log10(range.hi) + slack));
  const double low = range.lo * (1 - slack), high = range.hi * (1 + slack);
  // The multiples of every power of ten in the range by these digits.
  const auto values_of = [&](std::initializer_list<int> digits, int step) {
    std::vector<DecimalNumber> numbers;
    for (int power = first; power <= last; ++power)
      for (const int digit : digits)
        if (const DecimalNumber number{digit, power};
            power % step == 0 && number.value() >= low && number.value() <= high)
          numbers.push_back(number);
    return numbers;
  };
  std::vector<DecimalNumber> labelled = values_of({1}, 1);
  const auto room = static_cast<std::size_t>(std::max(most, 1));
  if (labelled.size() < 3) labelled = values_of({1, 2, 5}, 1);
  int step = 1;
  for (int next = 1; labelled.size() > room; ++next) labelled = values_of({1}, step = next);
  if (labelled.size() < 2) return ticks_of(range, most);
  std::vector<Tick> ticks;
  const bool is_plain = labelled.front().value() > 0.9e-4 && labelled.back().value() < 1.1e5;
  for (const DecimalNumber& number : labelled) ticks.push_back({number.value(), text_of(number, is_plain)});
  if (step > 1 || 2 * (last - first) > most) return ticks;
  for (const DecimalNumber& number : values_of({1, 2, 3, 4, 5, 6, 7, 8, 9}, 1))
    if (std::find(labelled.begin(), labelled.end(), number) == labelled.end()) ticks.push_back({number.value(), {}});
  return ticks;
}

std::vector<Tick> border_ticks(const std::vector<double>& borders, bool are_even, int most) {
  const auto room = static_cast<std::size_t>(std::max(most, 2));
  const std::size_t distance = label_distance(borders.size() - 1, room);
  const double largest = std::max(std::abs(borders.front()), std::abs(borders.back()));
  const bool by_power = largest >= 1e5 || borders[1] - borders[0] < 1e-4;
  std::vector<int> decimals;
  for (std::size_t i = 0; i < borders.size(); ++i) {
    const double width = i + 1 < borders.size() ? borders[i + 1] - borders[i] : borders[i] - borders[i - 1];
    decimals.push_back(decimals_within(borders[i], width / 200, by_power));
  }
  if (are_even) std::fill(decimals.begin(), decimals.end(), *std::max_element(decimals.begin(), decimals.end()));
  std::vector<Tick> ticks;
  for (std::size_t i = 0; i < borders.size(); ++i) {
    const bool is_labelled = i % distance == 0;
    if (!is_labelled && borders.size() > 5 * room) continue;
    const std::string text = borders[i] == 0 ? "0" : with_minus_signs(decimal_text(borders[i], decimals[i], by_power));
    ticks.push_back({borders[i], is_labelled ? text : std::string()});
  }
  return ticks;
}

}  // namespace rhoray::tools
