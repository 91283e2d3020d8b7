#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "render/framebuffer.h"

namespace rhoray::tools {

/// A picture's errors, pixel by pixel from the upper left corner (tools/validate/request.h).
struct ErrorMap {
  int width = 0, height = 0;
  std::span<const float> distance_cells;
  std::span<const float> depth_cells;
  std::span<const std::uint8_t> verdict;
};

struct ErrorPicture {
  render::Framebuffer framebuffer;
  std::string legend;  ///< what the colours mean
};

/// Where the drawn surface lies against the reference: blue below (smaller values), white on it, red above. The scale
/// ends at the 99.9 % quantile. Rays that were missed, false or elsewhere are magenta, undecided ones yellow.
ErrorPicture signed_distance_picture(const ErrorMap& map);

/// The error along the ray, from black (1e-16 cells or less) over red and yellow to white (1 cell or more), one colour
/// step a power of ten; misses as above.
ErrorPicture depth_error_picture(const ErrorMap& map);

}  // namespace rhoray::tools
