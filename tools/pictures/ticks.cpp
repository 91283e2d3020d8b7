#include "tools/pictures/ticks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace rhoray::tools {

namespace {

/// Number of decimals for numbers that are rounded to a step.
int decimals_of(double step) {
  return std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
}

std::string written(double value, double step, double largest) {
  char text[64];
  if (largest >= 1e5 || step < 1e-4) {
    const int digits = std::max(0, static_cast<int>(std::floor(std::log10(largest) - std::log10(step) + 1e-9)));
    std::snprintf(text, sizeof text, "%.*e", digits, value);
  } else {
    std::snprintf(text, sizeof text, "%.*f", decimals_of(step), value);
  }
  std::string written(text);
  if (value == 0) written = "0";
  for (std::size_t at; (at = written.find('-')) != std::string::npos;) written.replace(at, 1, "\u2212");
  return written;
}

/// 1, 2, 5, 10, 20, ..., and the same times negative powers of ten.
double next_step(double step) {
  const double power = std::pow(10, std::floor(std::log10(step) + 1e-9)), digit = std::round(step / power);
  return (digit < 2 ? 2 : digit < 5 ? 5 : 10) * power;
}

}  // namespace

std::vector<Tick> ticks_of(const Interval<double>& range, int most) {
  const double width = range.hi - range.lo;
  const double largest = std::max(std::abs(range.lo), std::abs(range.hi));
  if (!(width > largest * 1e-12)) {
    char text[64];
    std::snprintf(text, sizeof text, "%.6g", range.lo);
    return {{range.lo, text}};
  }
  const double slack = 1e-9;  // in steps: range ends that are multiples up to rounding are included
  double step = std::pow(10, std::floor(std::log10(width / std::max(most, 1))) - 1);
  const auto first = [&] { return std::ceil(range.lo / step - slack); };
  const auto last = [&] { return std::floor(range.hi / step + slack); };
  while (last() - first() + 1 > std::max(most, 1)) step = next_step(step);
  std::vector<Tick> ticks;
  for (double number = first(); number <= last(); ++number)
    ticks.push_back({number * step, written(number * step, step, largest)});
  return ticks;
}

}  // namespace rhoray::tools
