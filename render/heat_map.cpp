#include "render/heat_map.h"

#include <cmath>

#include "formats/base/checks.h"
#include "render/color_map.h"
#include "render/paint.h"

namespace rhoray::render {

namespace {

constexpr Vec3 no_number(0.21, 0.21, 0.21);  // linear

/// Returns the number drawn for a pixel, on the page's scale; NaN where there is none.
double number_at(DebugChannel page, const Framebuffer& picture, std::size_t pixel) {
  switch (page) {
    case DebugChannel::error: {
      const double error = static_cast<double>(picture.error[pixel]);
      return error > 0 ? std::log10(error) : std::numeric_limits<double>::quiet_NaN();
    }
    case DebugChannel::roots:
      return picture.roots[pixel];
    case DebugChannel::iterations:
      return picture.iterations[pixel];
    case DebugChannel::cost:
      break;
  }
  return picture.cost[pixel];
}

bool has_channel(DebugChannel page, const Framebuffer& picture) {
  const std::size_t count = page == DebugChannel::error        ? picture.error.size()
                            : page == DebugChannel::roots      ? picture.roots.size()
                            : page == DebugChannel::iterations ? picture.iterations.size()
                                                               : picture.cost.size();
  return count == picture.pixel_count();
}

}  // namespace

ChannelSet channel_of(DebugChannel page) {
  return {.error = page == DebugChannel::error,
          .roots = page == DebugChannel::roots,
          .iterations = page == DebugChannel::iterations,
          .cost = page == DebugChannel::cost};
}

Interval<double> draw_heat_map(DebugChannel page, Framebuffer& picture) {
  RHORAY_CHECK(has_channel(page, picture));
  Interval<double> range;
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    if (const double number = number_at(page, picture, pixel); std::isfinite(number)) range.include(number);
  const double width = range.hi - range.lo;
  paint(picture, [&](std::size_t pixel) {
    const double number = number_at(page, picture, pixel);
    if (!std::isfinite(number)) return no_number;
    return color_of(ColorMap::viridis, width > 0 ? (number - range.lo) / width : 0);
  });
  if (page == DebugChannel::error && !range.is_empty()) range = {std::pow(10, range.lo), std::pow(10, range.hi)};
  return range;
}

}  // namespace rhoray::render
