#pragma once

#include <span>
#include <string>

#include "render/framebuffer.h"
#include "tools/analysis/errors.h"

namespace rhoray::tools {

/// What colours mean in all error pictures of a report, so that they can be compared: viridis over the logarithm of an
/// error, from what is rounding to anyone to what anyone sees.
struct HeatScale {
  double least = 1e-8, most = 1;
  std::string unit;  ///< "cells along the ray"
  bool is_of_hits =
      true;  ///< pixels may be missed or false, and white is where nothing is; else white is no difference
};

struct HeatMapInput {
  int width = 0, height = 0;
  std::span<const float> errors;  ///< of every pixel, as ErrorList has them
  double unit = 1;                ///< what an error of 1 on the scale is
};

/// Errors as a picture: white where rightly nothing is shown or nothing was judged, or nothing differs; pixels that are
/// missed (red) or false (magenta) are drawn 3 x 3.
render::Framebuffer heat_map(const HeatMapInput& input, const HeatScale& scale);

/// The scale as HTML: a bar with its ends, and what the other colours mean.
std::string legend_html(const HeatScale& scale);

}  // namespace rhoray::tools
