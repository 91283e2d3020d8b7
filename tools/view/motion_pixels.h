#pragma once

#include <algorithm>
#include <cmath>

#include "render/scene_spec.h"

namespace rhoray::tools {

/// Chooses the number of pixels of pictures in motion, so that a user soon sees the effect of a move.
///
/// Tracing and encoding a picture takes at most 13 ms: a request waits for half a picture on average,
/// and then for its own. If pictures come faster than the client draws them, they wait there. They
/// then get less time, at least 5 ms, until making a picture and waiting take at most 14 ms together.
/// Preparing an isovalue uses up to two thirds of the time.
class MotionPixels {
 public:
  /// The size of a picture of the same shape; at least a 16th of the width and height.
  render::PictureSize size_for(const render::PictureSize& canvas) const {
    const double scale = std::clamp(std::sqrt(pixels_ / canvas.width / canvas.height), 1.0 / 16, 1.0);
    if (scale > 0.9) return canvas;
    const auto scaled = [&](int side) { return std::max(1, static_cast<int>(std::lround(scale * side))); };
    return {scaled(canvas.width), scaled(canvas.height)};
  }

  /// A picture was traced and encoded.
  /// @param preparation_ms  part of `ms` that does not depend on the number of pixels
  void took(double ms, double preparation_ms, const render::PictureSize& size) {
    const double left_ms = std::max(time_ms_ - preparation_ms, time_ms_ / 3);
    // Time grows more slowly than the number of pixels: for 256 times as many it grew 31 times on a CT.
    // The square root therefore goes about half of the way to the right number, and does not oscillate.
    const double factor = std::sqrt(left_ms / std::max(ms - preparation_ms, least_measured_ms));
    pixels_ = static_cast<double>(size.width) * size.height * std::clamp(factor, 0.7, 1.3);
  }

  /// A client has drawn a picture.
  /// @param ms          since the picture was begun, without preparation
  /// @param client_ms   since it was sent
  /// @param was_alone   the client had drawn all pictures before it
  void drawn(double ms, double client_ms, bool was_alone) {
    if (was_alone) alone_ms_ = std::min(client_ms, alone_ms_ + 0.05 * (client_ms - alone_ms_));
    const bool is_late = ms - alone_ms_ > latest_ms;
    time_ms_ = std::clamp(time_ms_ * (is_late ? 0.95 : 1.02), least_time_ms, most_time_ms);
  }

 private:
  static constexpr double most_time_ms = 13, least_time_ms = 5, latest_ms = 14, least_measured_ms = 0.1;

  double pixels_ = 2e5;
  double time_ms_ = most_time_ms;
  double alone_ms_ = 1000;  ///< that the client takes for a picture that does not wait; at first more than any
};

}  // namespace rhoray::tools
