#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "tools/pictures/pictures.h"

namespace rhoray::tools {

/// R, G, B
std::string listed(const std::vector<std::string>& channels);

/// Where two pictures differ most.
struct LargestDifference {
  double size = 0;
  std::string channel;
  int x = 0, y = 0;  ///< pixel, from the upper left corner
  double a = 0, b = 0;
};

/// How two pictures of one size differ, over the channels that both have. Numbers are as stored: of 8-bit pictures from
/// 0 to 1. Numbers that are both NaN, or the same infinity, are equal; one that is not finite differs from others by
/// infinity.
struct PictureDifference {
  std::vector<std::string> channels;        ///< compared
  std::vector<std::string> only_a, only_b;  ///< not compared
  std::vector<float> of_pixel;              ///< the largest over a pixel's channels
  LargestDifference largest;
  double mean = 0, root_mean_square = 0;  ///< over all numbers
  std::uint64_t differing = 0;            ///< pixels

  /// Pixels that differ by more than a limit.
  std::uint64_t beyond(double limit) const;
  /// 20 log10(1 / root_mean_square), decibels: of pictures whose numbers lie between 0 and 1.
  double peak_signal_to_noise() const;
};

/// Refuses pictures of two sizes, and those without a common channel (ErrorCode::invalid); names are those of the
/// files.
PictureDifference difference_of(const StoredPicture& a, const StoredPicture& b, const std::string& name_a,
                                const std::string& name_b);

/// Where pictures differ: black where they do not, then from dark to bright up to the largest difference that is
/// finite; magenta where one has a number that is not finite.
/// @param of_pixel  PictureDifference::of_pixel
render::Framebuffer difference_map(std::span<const float> of_pixel, int width, int height);

}  // namespace rhoray::tools
