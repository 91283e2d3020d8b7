#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "formats/base/read_value.h"
#include "render/scene_spec.h"

namespace rhoray::render {

namespace {

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
  const auto side = [&](std::size_t i) { return whole_number(sides[i]).value_or(0); };
  if (sides.size() != 2 || side(0) < 1 || side(1) < 1 || side(0) > largest_side || side(1) > largest_side)
    refuse_value(text, "WxH with sides from 1 to 65536, or 720p, 1080p, 4k");
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
  const std::vector<std::string> parts = split(text, ',');
  const auto part = [&](std::size_t i) { return finite_number(parts[i]).value_or(-1); };
  const auto is_share = [](double value) { return value >= 0 && value <= 1; };
  if (parts.size() != 3 || !is_share(part(0)) || !is_share(part(1)) || !is_share(part(2)))
    refuse_value(text, "a colour: #rrggbb, or r,g,b (linear) from 0 to 1");
  out.linear = {part(0), part(1), part(2)};
}

}  // namespace rhoray::render
