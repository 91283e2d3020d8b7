#include "render/color_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/color_map_tables.h"

namespace rhoray::render {

namespace {

constexpr NamedColorMap named_maps[] = {
    {"viridis", ColorMap::viridis},     {"viridis_r", {ColorMap::viridis, true}},
    {"magma", ColorMap::magma},         {"magma_r", {ColorMap::magma, true}},
    {"inferno", ColorMap::inferno},     {"inferno_r", {ColorMap::inferno, true}},
    {"plasma", ColorMap::plasma},       {"plasma_r", {ColorMap::plasma, true}},
    {"cividis", ColorMap::cividis},     {"cividis_r", {ColorMap::cividis, true}},
    {"gray", ColorMap::gray},           {"gray_r", {ColorMap::gray, true}},
    {"cubehelix", ColorMap::cubehelix}, {"cubehelix_r", {ColorMap::cubehelix, true}},
    {"turbo", ColorMap::turbo},         {"turbo_r", {ColorMap::turbo, true}},
    {"coolwarm", ColorMap::coolwarm},   {"coolwarm_r", {ColorMap::coolwarm, true}}};

Vec3 within_unit(const Vec3& color) {
  return {std::clamp(color.x, 0.0, 1.0), std::clamp(color.y, 0.0, 1.0), std::clamp(color.z, 0.0, 1.0)};
}

/// A number of two hexadecimal digits, 0 to 255.
int hex_pair(const char* digits) {
  const auto digit = [](char letter) { return letter <= '9' ? letter - '0' : letter - 'a' + 10; };
  return 16 * digit(digits[0]) + digit(digits[1]);
}

/// sRGB, interpolated between the colours of a table (color_map_tables.h).
Vec3 color_in(const char* table, double share) {
  constexpr int last = 255, digits = 6;
  const double place = last * share;
  const int before = std::min(last - 1, static_cast<int>(place));
  const auto color = [&](int at) {
    const char* const text = table + digits * at;
    return Vec3(hex_pair(text), hex_pair(text + 2), hex_pair(text + 4)) / 255.0;
  };
  return color(before) + (color(before + 1) - color(before)) * (place - before);
}

/// Equation 2 of the paper with its defaults: start 0.5, -1.5 rotations, hue 1, gamma 1. Its
/// colours are sRGB codes.
Vec3 cubehelix(double share) {
  const double angle = 2 * std::numbers::pi * (0.5 / 3 - 1.5 * share), amplitude = share * (1 - share) / 2;
  const double c = amplitude * std::cos(angle), s = amplitude * std::sin(angle);
  const Vec3 srgb(share - 0.14861 * c + 1.78277 * s, share - 0.29227 * c - 0.90649 * s, share + 1.97294 * c);
  return linear_from_srgb(within_unit(srgb));
}

/// CIE L*a*b* (D65) in polar coordinates: the paper's Msh.
struct Msh {
  double m, s, h;
};

constexpr double white[3] = {0.950489, 1, 1.088840};  // D65

Msh msh_from_srgb(int red, int green, int blue) {
  const Vec3 rgb = linear_from_srgb(Vec3(red, green, blue) / 255.0);
  const double xyz[3] = {0.4124 * rgb.x + 0.3576 * rgb.y + 0.1805 * rgb.z,
                         0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z,
                         0.0193 * rgb.x + 0.1192 * rgb.y + 0.9505 * rgb.z};
  double f[3];
  for (int i = 0; i < 3; ++i) {
    const double share = xyz[i] / white[i];
    f[i] = share > 216.0 / 24389 ? std::cbrt(share) : (24389.0 / 27 * share + 16) / 116;
  }
  const double l = 116 * f[1] - 16, a = 500 * (f[0] - f[1]), b = 200 * (f[1] - f[2]);
  const double m = std::sqrt(l * l + a * a + b * b);
  return {m, std::acos(l / m), std::atan2(b, a)};
}

Vec3 linear_from_msh(const Msh& msh) {
  const double l = msh.m * std::cos(msh.s), a = msh.m * std::sin(msh.s) * std::cos(msh.h),
               b = msh.m * std::sin(msh.s) * std::sin(msh.h);
  const double fy = (l + 16) / 116, f[3] = {fy + a / 500, fy, fy - b / 200};
  double xyz[3];
  for (int i = 0; i < 3; ++i)
    xyz[i] = white[i] * (f[i] > 6.0 / 29 ? f[i] * f[i] * f[i] : (116 * f[i] - 16) * 27 / 24389);
  return {3.2406 * xyz[0] - 1.5372 * xyz[1] - 0.4986 * xyz[2], -0.9689 * xyz[0] + 1.8758 * xyz[1] + 0.0415 * xyz[2],
          0.0557 * xyz[0] - 0.2040 * xyz[1] + 1.0570 * xyz[2]};
}

/// Returns the hue at which the path from a colour to white of magnitude m should end, so that it
/// looks straight.
double hue_at_white(const Msh& color, double m) {
  if (color.m >= m) return color.h;
  const double turn = color.s * std::sqrt(m * m - color.m * color.m) / (color.m * std::sin(color.s));
  return color.h > -std::numbers::pi / 3 ? color.h + turn : color.h - turn;
}

Vec3 coolwarm(double share) {
  static const Msh cool = msh_from_srgb(59, 76, 192), warm = msh_from_srgb(180, 4, 38);
  constexpr double m_white = 88;
  const Msh& end = share < 0.5 ? cool : warm;
  const double to_white = share < 0.5 ? 2 * share : 2 - 2 * share;
  const double m_mid = std::max({cool.m, warm.m, m_white});
  const double h_mid = hue_at_white(end, m_mid);
  const Msh color{end.m + to_white * (m_mid - end.m), end.s * (1 - to_white), end.h + to_white * (h_mid - end.h)};
  return within_unit(linear_from_msh(color));
}

}  // namespace

std::span<const NamedColorMap> color_maps() {
  return named_maps;
}

Vec3 linear_from_srgb(const Vec3& encoded) {
  const auto linear = [](double part) {
    return part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4);
  };
  return {linear(encoded.x), linear(encoded.y), linear(encoded.z)};
}

Vec3 color_of(ColorMap map, double share) {
  share = std::clamp(share, 0.0, 1.0);
  if (map.is_reversed) share = 1 - share;
  switch (map.base) {
    case ColorMap::viridis:
      return linear_from_srgb(color_in(viridis_table, share));
    case ColorMap::magma:
      return linear_from_srgb(color_in(magma_table, share));
    case ColorMap::inferno:
      return linear_from_srgb(color_in(inferno_table, share));
    case ColorMap::plasma:
      return linear_from_srgb(color_in(plasma_table, share));
    case ColorMap::cividis:
      return linear_from_srgb(color_in(cividis_table, share));
    case ColorMap::turbo:
      return linear_from_srgb(color_in(turbo_table, share));
    case ColorMap::cubehelix:
      return cubehelix(share);
    case ColorMap::coolwarm:
      return coolwarm(share);
    case ColorMap::gray:
      break;
  }
  return linear_from_srgb(Vec3(share));
}

double position_of(const ColorScale& scale, const Interval<double>& range, double value) {
  if (scale.is_logarithmic) return std::log(value / range.lo) / std::log(range.hi / range.lo);
  return (value - range.lo) / (range.hi - range.lo);
}

double value_at(const ColorScale& scale, const Interval<double>& range, double position) {
  if (scale.is_logarithmic) return range.lo * std::pow(range.hi / range.lo, position);
  return range.lo + position * (range.hi - range.lo);
}

double position_in_map(const ColorScale& scale, double position) {
  if (scale.levels == 0) return position;
  const double last = scale.levels - 1;
  return std::clamp(std::floor(position * scale.levels), 0.0, last) / last;
}

}  // namespace rhoray::render
