#include "tools/analysis/heat_map.h"

#include <algorithm>
#include <cmath>

#include "formats/base/text.h"
#include "render/color_map.h"
#include "render/paint.h"
#include "render/png.h"
#include "render/truth.h"

namespace rhoray::tools {

namespace {

const Vec3 nothing(1, 1, 1), missed(0.8, 0, 0.02), false_hit(0.9, 0, 0.9);

/// A colour in CSS syntax.
std::string css_color(const Vec3& linear) {
  const auto byte = [&](int c) { return int{render::srgb_byte(static_cast<float>(linear[c]))}; };
  return concat("rgb(", byte(0), ",", byte(1), ",", byte(2), ")");
}

Vec3 viridis(double share) {
  return render::color_of(render::ColorMap::viridis, share);
}

}  // namespace

render::Framebuffer heat_map(const HeatMapInput& input, const HeatScale& scale) {
  render::Framebuffer picture(input.width, input.height, {});
  const double decades = std::log10(scale.most / scale.least);
  render::paint(picture, [&](std::size_t pixel) {
    const auto error = static_cast<double>(input.errors[pixel]);
    const double share = std::log10(std::max(error / input.unit, scale.least) / scale.least);
    return std::isnan(error) || (!scale.is_of_hits && share <= 0) ? nothing : viridis(share / decades);
  });
  // A single wrong pixel would not be seen.
  for (std::size_t pixel = 0; pixel < input.errors.size(); ++pixel) {
    if (!std::isinf(input.errors[pixel])) continue;
    const int x = static_cast<int>(pixel) % input.width, y = static_cast<int>(pixel) / input.width;
    const Vec3& color = input.errors[pixel] == render::is_missed ? missed : false_hit;
    for (int j = std::max(0, y - 1); j <= std::min(input.height - 1, y + 1); ++j)
      for (int i = std::max(0, x - 1); i <= std::min(input.width - 1, x + 1); ++i)
        render::paint(picture, static_cast<std::size_t>(j * input.width + i), color);
  }
  return picture;
}

Json legend_json(const HeatScale& scale) {
  constexpr int parts = 8;
  std::string stops;
  for (int part = 0; part <= parts; ++part)
    stops += concat(part == 0 ? "" : ",", css_color(viridis(static_cast<double>(part) / parts)));
  const auto mark = [](const Vec3& color, const char* meaning) {
    return Json{{"color", css_color(color)}, {"meaning", meaning}};
  };
  Json legend{{"unit", scale.unit}, {"least", scale.least},           {"most", scale.most},
              {"stops", stops},     {"is_of_hits", scale.is_of_hits}, {"marks", Json::array()}};
  if (scale.is_of_hits)
    legend["marks"] = {mark(missed, "false negative"), mark(false_hit, "false positive (both drawn 3 × 3 pixels)"),
                       mark(nothing, "nothing there, or not checked")};
  else
    legend["marks"].push_back(mark(nothing, "less"));
  return legend;
}

render::Framebuffer difference_map(std::span<const float> of_pixel, int width, int height) {
  float scale = 0;
  for (const float size : of_pixel)
    if (std::isfinite(size)) scale = std::max(scale, size);
  render::Framebuffer map(width, height, {});
  render::paint(map, [&](std::size_t pixel) {
    const float size = of_pixel[pixel];
    if (!std::isfinite(size)) return Vec3(1, 0, 1);
    return size == 0 ? Vec3(0, 0, 0) : viridis(static_cast<double>(size / scale));
  });
  return map;
}

}  // namespace rhoray::tools
