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
  std::string legend;  ///< meaning of the colours
};

/// Signed distance of the rendered surface from the reference: blue below (smaller values), white
/// on it, red above. The scale ends at the 99.9 % quantile. Missed, false and elsewhere rays are
/// magenta, undecided ones yellow.
ErrorPicture signed_distance_picture(const ErrorMap& map);

/// The error along the ray, from black (1e-16 cells or less) over red and yellow to white (1 cell
/// or more). Equal steps of colour are powers of ten. Misses are coloured as above.
ErrorPicture depth_error_picture(const ErrorMap& map);

}  // namespace rhoray::tools
