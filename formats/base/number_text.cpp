#include "formats/base/number_text.h"

#include <cstdio>
#include <string_view>

#include "formats/base/text.h"

namespace rhoray {

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

}  // namespace rhoray
