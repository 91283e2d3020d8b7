#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "tools/pictures/canvas.h"

namespace rhoray::tests {

/// A picture of one grey in which nothing is hit.
inline render::Framebuffer blank(int width, int height, float grey = 1) {
  render::Framebuffer picture(width, height, {.depth = true});
  picture.background = {grey, grey, grey};
  for (std::size_t p = 0; p < picture.pixel_count(); ++p) {
    for (std::size_t c = 0; c < 3; ++c) picture.color[4 * p + c] = grey;
    picture.color[4 * p + 3] = 0;
    picture.depth[p] = std::numeric_limits<float>::infinity();
  }
  return picture;
}

/// Solid letters of 6 x 10.
inline tools::TextImage blocks(const std::string& text, int pixels) {
  const int width = static_cast<int>(text.size()) * pixels * 6 / 10;
  return {.left = 0,
          .top = -pixels,
          .width = width,
          .height = pixels,
          .coverage = std::vector<float>(static_cast<std::size_t>(width * pixels), 1.0F)};
}

inline Vec3 color_at(const render::Framebuffer& picture, int x, int y) {
  const std::size_t p = 4 * static_cast<std::size_t>(y * picture.width + x);
  return Vec3(picture.color[p], picture.color[p + 1], picture.color[p + 2]);
}

}  // namespace rhoray::tests
