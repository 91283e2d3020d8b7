#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/pictures/pictures.h"

namespace rhoray::tools {

/// Formats a list: R, G, B.
std::string listed(const std::vector<std::string>& channels);

/// The largest difference between two pictures.
struct LargestDifference {
  double size = 0;
  std::string channel;
  int x = 0, y = 0;  ///< pixel, from the upper left corner
  double a = 0, b = 0;
};

/// Difference of two pictures of the same size, over the channels that both have. Numbers are those
/// of StoredPicture. Numbers that are both NaN, or the same infinity, are equal. One that is not
/// finite differs from all others by infinity.
struct PictureDifference {
  std::vector<std::string> channels;        ///< compared
  std::vector<std::string> only_a, only_b;  ///< not compared
  std::vector<float> of_pixel;              ///< the largest over a pixel's channels
  LargestDifference largest;
  double mean = 0, root_mean_square = 0;  ///< over all numbers
  std::uint64_t differing = 0;            ///< pixels

  /// Number of pixels that differ by more than a limit.
  std::uint64_t beyond(double limit) const;
  /// 20 log10(1 / root_mean_square), decibels; for pictures whose numbers are between 0 and 1.
  double peak_signal_to_noise() const;
};

/// Refuses pictures of different sizes, and those without a common channel (ErrorCode::invalid).
/// The names are those of the files.
PictureDifference difference_of(const StoredPicture& a, const StoredPicture& b, const std::string& name_a,
                                const std::string& name_b);

}  // namespace rhoray::tools
