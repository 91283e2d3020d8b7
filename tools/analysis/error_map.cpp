#include "tools/analysis/error_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "formats/base/vector.h"
#include "tools/validate/report.h"
#include "tools/validate/request.h"

namespace rhoray::tools {

namespace {

const Vec3 background(0.03, 0.03, 0.03), wrong(1, 0, 1), undecided(1, 0.8, 0), below(0.02, 0.12, 0.6),
    above(0.6, 0.02, 0.05);

constexpr const char* marks =
    "magenta: false negative, false positive or different cell; yellow: undecided; dark: nothing";

render::Framebuffer painted(const ErrorMap& map, const std::function<Vec3(std::size_t)>& color_of) {
  render::Framebuffer picture(map.width, map.height, {});
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel) {
    using validate::Verdict;
    const std::uint8_t number = map.verdict[pixel];
    const auto verdict = static_cast<Verdict>(number);
    const bool is_wrong = verdict == Verdict::missed || verdict == Verdict::false_hit || verdict == Verdict::elsewhere;
    const Vec3 color = number == validate::no_verdict  ? background
                       : is_wrong                      ? wrong
                       : verdict == Verdict::undecided ? undecided
                                                       : color_of(pixel);
    for (int channel = 0; channel < 3; ++channel)
      picture.color[4 * pixel + static_cast<std::size_t>(channel)] = static_cast<float>(color[channel]);
    picture.color[4 * pixel + 3] = 1;
  }
  return picture;
}

double quantile(std::span<const float> values, double share) {
  std::vector<double> sizes;
  for (const float value : values)
    if (std::isfinite(value)) sizes.push_back(std::abs(static_cast<double>(value)));
  if (sizes.empty()) return 0;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

}  // namespace

ErrorPicture signed_distance_picture(const ErrorMap& map) {
  const double scale = std::max(quantile(map.distance_cells, 0.999), 1e-300);
  const auto color_of = [&](std::size_t pixel) {
    const double value = map.distance_cells[pixel];
    if (std::isnan(value)) return background;
    const double share = std::clamp(value / scale, -1.0, 1.0);
    const Vec3 white(1, 1, 1);
    return white + std::abs(share) * ((share < 0 ? below : above) - white);
  };
  return {painted(map, color_of), concat("signed distance from the reference, blue ", rounded(-scale), " cells to red ",
                                         rounded(scale), " cells; ", marks)};
}

ErrorPicture depth_error_picture(const ErrorMap& map) {
  const auto color_of = [&](std::size_t pixel) {
    const double value = map.depth_cells[pixel];
    if (std::isnan(value)) return background;
    const double share = std::clamp((std::log10(std::max(value, 1e-16)) + 16) / 16, 0.0, 1.0);
    return Vec3(std::min(1.0, 3 * share), std::clamp(3 * share - 1, 0.0, 1.0), std::clamp(3 * share - 2, 0.0, 1.0));
  };
  return {painted(map, color_of),
          concat("error along the ray, black 1e-16 cells, red 5e-11, yellow 2e-5, white 1 cell; ", marks)};
}

}  // namespace rhoray::tools
