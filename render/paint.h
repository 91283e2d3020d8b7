#pragma once

#include <cstddef>

#include "formats/base/vector.h"
#include "render/framebuffer.h"

namespace rhoray::render {

/// Sets the colour of a pixel: linear RGB, opaque.
inline void paint(Framebuffer& picture, std::size_t pixel, const Vec3& color) {
  for (std::size_t c = 0; c < 3; ++c) picture.color[4 * pixel + c] = static_cast<float>(color[static_cast<int>(c)]);
  picture.color[4 * pixel + 3] = 1;
}

/// Sets the colour of every pixel to color_of(pixel).
template <class ColorOf>
void paint(Framebuffer& picture, const ColorOf& color_of) {
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel) paint(picture, pixel, color_of(pixel));
}

}  // namespace rhoray::render
