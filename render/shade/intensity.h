#pragma once

#include "formats/base/interval.h"
#include "render/shade/color_scale.h"
#include "render/shade/color_table.h"
#include "render/shade/lanes.h"
#include "render/shade/power.h"

namespace rhoray::render {

/// Adds the grey of values in a maximum-intensity projection: black at the low end of the window,
/// white at its high end. Shares of the window become shares of the sRGB code, so that steps look
/// even. The result is the linear light of that code.
RHORAY_INLINE void add_intensity(const Interval<double>& window, const double* values, Colors& colors) {
  const double low = window.lo, width = window.hi - window.lo;
  Lanes shares;
  for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = static_cast<float>((values[i] - low) / width);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const float above = shares[i] < 0 ? 0 : shares[i];
    const float share = above < 1 ? above : 1;  // only a window without width gives a NaN
    const float curved = power((share + 0.055F) / 1.055F, 2.4F);
    const float light = share <= 0.04045F ? share / 12.92F : curved;
    colors.red[i] += light;
    colors.green[i] += light;
    colors.blue[i] += light;
  }
}

/// Sets the colours of values in a projection: grey as above, or those of another map.
RHORAY_INLINE void find_intensity(ColorMap map, const ColorScale& scale, const Interval<double>& window,
                                  const double* values, Colors& colors) {
  double positions[RayBatch::group_size];
  const EvenNumbers even = spread_evenly(scale, window, values, positions);
  if (map == ColorMap::gray)
    add_intensity(even.range, even.numbers, colors);
  else
    ColorTable::of(map).look_up(even.numbers, even.range, colors);
}

}  // namespace rhoray::render
