#include "tools/analysis/picture_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "formats/base/checks.h"
#include "formats/base/vector.h"
#include "render/png.h"

namespace rhoray::tools {

namespace {

std::vector<float> rgb_of(const render::Framebuffer& picture) {
  std::vector<float> rgb;
  rgb.reserve(3 * picture.pixel_count());
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    rgb.insert(rgb.end(), picture.color.begin() + static_cast<std::ptrdiff_t>(4 * pixel),
               picture.color.begin() + static_cast<std::ptrdiff_t>(4 * pixel + 3));
  return rgb;
}

Vec3 normal_at(const render::Framebuffer& picture, std::size_t pixel) {
  return {picture.normal[3 * pixel], picture.normal[3 * pixel + 1], picture.normal[3 * pixel + 2]};
}

std::optional<render::Quantiles> normal_angles(const render::Framebuffer& truth, const render::Framebuffer& picture) {
  if (truth.normal.empty() || picture.normal.empty()) return std::nullopt;
  std::vector<double> angles;
  for (std::size_t pixel = 0; pixel < truth.pixel_count(); ++pixel) {
    const Vec3 p = normal_at(truth, pixel), q = normal_at(picture, pixel);
    if (p == Vec3(0, 0, 0) || q == Vec3(0, 0, 0)) continue;
    angles.push_back(std::atan2(p.cross(q).length(), p.dot(q)) * 180 / std::numbers::pi);
  }
  return render::quantiles_of(std::move(angles));
}

}  // namespace

TruePicture::TruePicture(render::Framebuffer picture)
    : picture_(std::move(picture)), flip_(picture_.width, picture_.height, rgb_of(picture_)) {}

PictureErrors TruePicture::against(const render::Framebuffer& picture) const {
  RHORAY_CHECK(picture.width == picture_.width && picture.height == picture_.height);
  double squares = 0;
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    for (std::size_t c = 0; c < 3; ++c) {
      const float is = picture_.color[4 * pixel + c], said = picture.color[4 * pixel + c];
      if (is != said) squares += std::pow(render::srgb_byte(is) - render::srgb_byte(said), 2);
    }
  std::vector<float> flip_map = flip_.against(rgb_of(picture));
  const double flip = mean_of(flip_map);
  return {.rmse = std::sqrt(squares / (3 * static_cast<double>(picture.pixel_count()))),
          .flip = flip,
          .flip_map = std::move(flip_map),
          .normal_deg = normal_angles(picture_, picture)};
}

render::Framebuffer enlarged(const render::Framebuffer& picture, int width, int height) {
  render::Framebuffer large(width, height, {});
  struct Between {
    int low, high;
    float share;
  };
  const auto between = [](int at, int to, int from) {
    const double place = std::clamp((at + 0.5) * from / to - 0.5, 0.0, static_cast<double>(from - 1));
    const int low = static_cast<int>(place);
    return Between{low, std::min(low + 1, from - 1), static_cast<float>(place - low)};
  };
  const auto index = [](int x, int y, int row) {
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(row) + static_cast<std::size_t>(x));
  };
  for (int y = 0; y < height; ++y) {
    const Between v = between(y, height, picture.height);
    for (int x = 0; x < width; ++x) {
      const Between u = between(x, width, picture.width);
      for (std::size_t c = 0; c < 4; ++c) {
        const auto at = [&](int i, int j) { return picture.color[index(i, j, picture.width) + c]; };
        const float upper = std::lerp(at(u.low, v.low), at(u.high, v.low), u.share);
        const float lower = std::lerp(at(u.low, v.high), at(u.high, v.high), u.share);
        large.color[index(x, y, width) + c] = std::lerp(upper, lower, v.share);
      }
    }
  }
  return large;
}

}  // namespace rhoray::tools
