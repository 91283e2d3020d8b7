#include "tools/analysis/heat_map.h"

#include <algorithm>
#include <cmath>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "render/color_map.h"
#include "tools/analysis/html.h"

namespace rhoray::tools {

namespace {

const Vec3 nothing(1, 1, 1), missed(0.8, 0, 0.02), false_hit(0.9, 0, 0.9);

void paint(render::Framebuffer& picture, int x, int y, const Vec3& color) {
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
  float* const pixel = &picture.color[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                           static_cast<std::size_t>(x))];
  for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(color[c]);
  pixel[3] = 1;
}

/// A colour in CSS syntax.
std::string css_color(const Vec3& linear) {
  std::string text = "rgb(";
  for (int c = 0; c < 3; ++c) {
    const double value = linear[c],
                 code = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
    text += concat(c == 0 ? "" : ",", std::lround(255 * code));
  }
  return text + ")";
}

}  // namespace

render::Framebuffer heat_map(const HeatMapInput& input, const HeatScale& scale) {
  render::Framebuffer picture(input.width, input.height, {});
  const double decades = std::log10(scale.most / scale.least);
  const auto error_at = [&](int x, int y) {
    return input
        .errors[static_cast<std::size_t>(y) * static_cast<std::size_t>(input.width) + static_cast<std::size_t>(x)];
  };
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x) {
      const float error = error_at(x, y);
      const double share = std::log10(std::max(static_cast<double>(error) / input.unit, scale.least) / scale.least);
      const bool is_nothing = std::isnan(error) || (!scale.is_of_hits && share <= 0);
      paint(picture, x, y, is_nothing ? nothing : render::color_of(render::ColorMap::viridis, share / decades));
    }
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x)
      if (const float error = error_at(x, y); error == render::is_missed || error == render::is_false)
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) paint(picture, x + i, y + j, error == render::is_missed ? missed : false_hit);
  return picture;
}

std::string legend_html(const HeatScale& scale) {
  std::string stops;
  constexpr int parts = 8;
  for (int part = 0; part <= parts; ++part)
    stops += concat(part == 0 ? "" : ",",
                    css_color(render::color_of(render::ColorMap::viridis, static_cast<double>(part) / parts)));
  const auto square = [](const Vec3& color, const char* meaning) {
    return concat("<span class=\"square\" style=\"background:", css_color(color), "\"></span> ", meaning, " ");
  };
  const std::string marks = scale.is_of_hits
                                ? square(missed, "false negative") + square(false_hit, "false positive") +
                                      "(both drawn 3 × 3 pixels) " + square(nothing, "nothing there, or not checked")
                                : square(nothing, "less");
  return concat("<p class=\"legend\">", html_text(scale.unit), ": ", scale.is_of_hits ? "≤ " : "",
                with_powers(rounded(scale.least)), " <span class=\"bar\" style=\"background:linear-gradient(to right,",
                stops, ")\"></span> ", scale.is_of_hits ? "≥ " : "", with_powers(rounded(scale.most)), " &emsp; ",
                marks, "</p>\n");
}

}  // namespace rhoray::tools
