#pragma once

#include <span>
#include <string>

#include "formats/base/json.h"
#include "render/framebuffer.h"

namespace rhoray::tools {

/// Colour scale shared by all error pictures of a report, so that they can be compared: viridis
/// over the logarithm of the error, from rounding errors to errors that anyone sees.
struct HeatScale {
  double least = 1e-8, most = 1;
  std::string unit;  ///< "cells along the ray"
  /// True: pixels may be missed or false, and white means that nothing is shown. False: white means
  /// no difference.
  bool is_of_hits = true;
};

struct HeatMapInput {
  int width = 0, height = 0;
  std::span<const float> errors;  ///< for every pixel, as in render::ErrorList
  double unit = 1;                ///< error that corresponds to 1 on the scale
};

/// Draws errors as a picture. White means: correctly nothing is shown, not examined, or no
/// difference. Missed (red) and false (magenta) pixels are drawn 3 x 3.
render::Framebuffer heat_map(const HeatMapInput& input, const HeatScale& scale);

/// The scale for the report's template: its unit and ends, `stops` of a CSS gradient, and `marks`,
/// the meaning of the other colours.
Json legend_json(const HeatScale& scale);

/// Picture of differences: black where there is none, then from dark to bright up to the largest
/// finite difference. Magenta where one picture has a number that is not finite.
/// @param of_pixel  PictureDifference::of_pixel
render::Framebuffer difference_map(std::span<const float> of_pixel, int width, int height);

}  // namespace rhoray::tools
