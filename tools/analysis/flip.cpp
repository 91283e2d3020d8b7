#include "tools/analysis/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/checks.h"

namespace rhoray::tools {

namespace {

using Color = std::array<double, 3>;
using Plane = std::vector<float>;
using Planes = std::array<Plane, 3>;

// The paper's constants.
constexpr double pixels_per_degree = 67.0206;  // 0.7 m * (3840 pixels / 0.7 m) * pi / 180
constexpr double color_exponent = 0.7, large_share = 0.4, large_error = 0.95, feature_exponent = 0.5,
                 feature_width_deg = 0.082;

/// Spatial sensitivity to brightness, red-green and blue-yellow: sums of two Gaussians
/// a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> sensitivities{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

constexpr std::array<Color, 3> xyz_from_rgb{{{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                             {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                             {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}}};

Color xyz_of(const Color& rgb) {
  Color xyz{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t c = 0; c < 3; ++c) xyz[row] += xyz_from_rgb[row][c] * rgb[c];
  return xyz;
}

/// Relative to white, D65.
Color relative(const Color& xyz) {
  static const Color white = xyz_of({1, 1, 1});
  return {xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]};
}

/// Brightness, red-green, blue-yellow, linear in the light (YCxCz).
Color opponent_of(const Color& rgb) {
  const Color xyz = relative(xyz_of(rgb));
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

/// The inverse, clamped to what a screen can show.
Color rgb_of(const Color& opponent) {
  static const Color white = xyz_of({1, 1, 1});
  const double y = (opponent[0] + 16) / 116;
  const Color xyz{white[0] * (y + opponent[1] / 500), white[1] * y, white[2] * (y - opponent[2] / 200)};
  const auto& m = xyz_from_rgb;
  const auto minor = [&](std::size_t r, std::size_t c) {
    const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
  };
  const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  Color rgb{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t c = 0; c < 3; ++c) rgb[row] += minor(c, row) / determinant * xyz[c];
    rgb[row] = std::clamp(rgb[row], 0.0, 1.0);
  }
  return rgb;
}

/// CIELAB; colourfulness decreases with brightness (Hunt).
Color lab_of(const Color& rgb) {
  const Color xyz = relative(xyz_of(rgb));
  constexpr double delta = 6.0 / 29;
  const auto f = [](double t) { return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29; };
  const double lightness = 116 * f(xyz[1]) - 16, hunt = 0.01 * lightness;
  return {lightness, hunt * 500 * (f(xyz[0]) - f(xyz[1])), hunt * 200 * (f(xyz[1]) - f(xyz[2]))};
}

double hyab(const Color& p, const Color& q) {
  return std::abs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]);
}

/// 0 to 1; the largest possible distance, green to blue, becomes 1.
double color_error(const Color& p, const Color& q) {
  static const double most = std::pow(hyab(lab_of({0, 1, 0}), lab_of({0, 0, 1})), color_exponent);
  const double error = std::pow(hyab(p, q), color_exponent), knee = large_share * most;
  if (error < knee) return large_error / knee * error;
  return large_error + (error - knee) / (most - knee) * (1 - large_error);
}

using Weights = std::vector<double>;  ///< from -radius to radius

template <class F>
Weights weights(int radius, F&& f) {
  Weights list;
  for (int x = -radius; x <= radius; ++x) list.push_back(f(static_cast<double>(x)));
  return list;
}

/// Scales positive weights to a sum of 1, negative ones to -1.
Weights balanced(Weights list) {
  double above = 0, below = 0;
  for (const double weight : list) (weight > 0 ? above : below) += std::abs(weight);
  for (double& weight : list) weight /= weight > 0 ? above : below > 0 ? below : 1;
  return list;
}

/// Filters along one axis, then along the other. The picture is extended by its edge pixels.
struct Filter {
  int width, height;

  Plane operator()(const Plane& in, const Weights& along_x, const Weights& along_y) const {
    return pass(pass(in, along_x, 1, 0), along_y, 0, 1);
  }

  Plane pass(const Plane& in, const Weights& list, int step_x, int step_y) const {
    const int radius = static_cast<int>(list.size() / 2);
    Plane out(in.size());
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (int i = -radius; i <= radius; ++i) {
          const int at_x = std::clamp(x + i * step_x, 0, width - 1), at_y = std::clamp(y + i * step_y, 0, height - 1);
          sum += list[static_cast<std::size_t>(i + radius)] * static_cast<double>(in[index(at_x, at_y)]);
        }
        out[index(x, y)] = static_cast<float>(sum);
      }
    return out;
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// Filters a channel to what the eye resolves: a normalised sum of two Gaussians, each separable
/// along the axes.
Plane blurred(const Filter& filter, const Plane& channel, const Sensitivity& s) {
  constexpr double pi = std::numbers::pi;
  static const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * pixels_per_degree));
  const auto part = [&](double a, double b, double& total) {
    Weights list = weights(radius, [&](double x) {
      const double degrees = x / pixels_per_degree;
      return std::exp(-pi * pi * degrees * degrees / b);
    });
    double sum = 0;
    for (const double weight : list) sum += weight;
    for (double& weight : list) weight /= sum;
    total = a * std::sqrt(pi / b) * sum * sum;
    return list;
  };
  double share1 = 0, share2 = 0;
  const Weights first = part(s.a1, s.b1, share1), second = part(s.a2, s.b2, share2);
  Plane out = filter(channel, first, first);
  if (share2 == 0) return out;
  const Plane other = filter(channel, second, second);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<float>((share1 * static_cast<double>(out[i]) + share2 * static_cast<double>(other[i])) /
                                (share1 + share2));
  return out;
}

Plane length_of(Plane x, const Plane& y) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::hypot(x[i], y[i]);
  return x;
}

}  // namespace

/// What is perceived of one picture.
struct Flip::Seen {
  std::vector<Color> lab;
  Plane edges, points;

  Seen(const Filter& filter, std::span<const float> rgb) {
    const std::size_t count = rgb.size() / 3;
    Planes channels;
    Plane brightness(count);
    for (Plane& channel : channels) channel.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      Color color{};
      for (std::size_t c = 0; c < 3; ++c) color[c] = std::clamp(static_cast<double>(rgb[3 * i + c]), 0.0, 1.0);
      const Color opponent = opponent_of(color);
      for (std::size_t c = 0; c < 3; ++c) channels[c][i] = static_cast<float>(opponent[c]);
      brightness[i] = static_cast<float>((opponent[0] + 16) / 116);
    }
    for (std::size_t c = 0; c < 3; ++c) channels[c] = blurred(filter, channels[c], sensitivities[c]);
    lab.resize(count);
    for (std::size_t i = 0; i < count; ++i) lab[i] = lab_of(rgb_of({channels[0][i], channels[1][i], channels[2][i]}));

    constexpr double deviation = 0.5 * feature_width_deg * pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    const auto bell = [&](double x) { return std::exp(-x * x / (2 * deviation * deviation)); };
    Weights across = weights(radius, bell);
    double sum = 0;
    for (const double weight : across) sum += weight;
    for (double& weight : across) weight /= sum;
    const Weights slope = balanced(weights(radius, [&](double x) { return -x * bell(x); }));
    const Weights bend =
        balanced(weights(radius, [&](double x) { return (x * x / (deviation * deviation) - 1) * bell(x); }));
    edges = length_of(filter(brightness, slope, across), filter(brightness, across, slope));
    points = length_of(filter(brightness, bend, across), filter(brightness, across, bend));
  }
};

Flip::Flip(int width, int height, std::span<const float> rgb)
    : width_(width), height_(height), reference_(std::make_unique<Seen>(Filter{width, height}, rgb)) {}

Flip::~Flip() = default;

std::vector<float> Flip::against(std::span<const float> rgb) const {
  RHORAY_CHECK(rgb.size() == 3 * reference_->lab.size());
  const Seen seen(Filter{width_, height_}, rgb);
  std::vector<float> errors(seen.lab.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double color = color_error(reference_->lab[i], seen.lab[i]);
    const double feature = std::max(std::abs(static_cast<double>(reference_->edges[i] - seen.edges[i])),
                                    std::abs(static_cast<double>(reference_->points[i] - seen.points[i])));
    const double seen_as = std::pow(std::numbers::sqrt2 / 2 * feature, feature_exponent);
    errors[i] = static_cast<float>(std::pow(color, 1 - seen_as));
  }
  return errors;
}

double mean_of(std::span<const float> numbers) {
  double sum = 0;
  for (const float number : numbers) sum += static_cast<double>(number);
  return numbers.empty() ? 0 : sum / static_cast<double>(numbers.size());
}

}  // namespace rhoray::tools
