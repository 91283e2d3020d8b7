#pragma once

#include <algorithm>
#include <cmath>

#include "render/scene_spec.h"

namespace rhoray::tools {

/// Chooses the number of pixels of a picture in motion, so that tracing and encoding it takes 13 ms.
/// A request waits for half a picture on average, and then for its own.
class MotionPixels {
 public:
  /// The size of a picture of the same shape; at least a 16th of the width and height.
  render::PictureSize size_for(const render::PictureSize& canvas) const {
    const double scale = std::clamp(std::sqrt(pixels_ / canvas.width / canvas.height), 1.0 / 16, 1.0);
    if (scale > 0.9) return canvas;
    const auto scaled = [&](int side) { return std::max(1, static_cast<int>(std::lround(scale * side))); };
    return {scaled(canvas.width), scaled(canvas.height)};
  }

  void took(double ms, const render::PictureSize& size) {
    // Time grows more slowly than the number of pixels: for 256 times as many it grew 31 times on a CT.
    // The square root therefore goes about half of the way to the right number, and does not oscillate.
    pixels_ = static_cast<double>(size.width) * size.height * std::clamp(std::sqrt(target_ms / ms), 0.7, 1.3);
  }

 private:
  static constexpr double target_ms = 13;

  double pixels_ = 2e5;
};

}  // namespace rhoray::tools
