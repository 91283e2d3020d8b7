#pragma once

#include <algorithm>
#include <cmath>

#include "render/scene_spec.h"
#include "tools/view/sent_pictures.h"

namespace rhoray::tools {

/// Chooses the number of pixels of pictures in motion, so that a user soon sees the effect of a
/// move.
///
/// The painter has at most 13 ms to trace and encode a picture: a request waits for half a picture
/// on average, and then for its own. If the client draws more slowly than pictures come, they wait
/// there. Then the painter gets less time, but at least 5 ms, until a picture takes at most 14 ms
/// for work and waiting. These times gave drags of 15 to 32 ms at the median in Chromium on two
/// cores, which took 57 to 60 ms with 13 ms of work alone. Preparing an isovalue uses up to two
/// thirds of the time.
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
    // Time grows more slowly than the number of pixels: for 256 times as many it grew 31 times on a
    // CT. The square root therefore goes about half of the way to the right number, and does not
    // oscillate.
    const double factor = std::sqrt(left_ms / std::max(ms - preparation_ms, least_measured_ms));
    pixels_ = static_cast<double>(size.width) * size.height * std::clamp(factor, 0.7, 1.3);
  }

  /// A client has drawn a picture.
  void drawn(const SentPictures::Delay& delay) {
    if (delay.was_alone) alone_ms_ = std::min(delay.client_ms, alone_ms_ + 0.05 * (delay.client_ms - alone_ms_));
    const bool is_late = delay.whole_ms > alone_ms_ + longest_ms;
    time_ms_ = std::clamp(time_ms_ * (is_late ? 0.95 : 1.02), least_time_ms, most_time_ms);
  }

 private:
  static constexpr double most_time_ms = 13, least_time_ms = 5, longest_ms = 14, least_measured_ms = 0.1;

  double pixels_ = 2e5;
  double time_ms_ = most_time_ms;
  double alone_ms_ = 1000;  ///< the client's time for a picture that does not wait; at first unknown
};

}  // namespace rhoray::tools
