#pragma once

#include <array>
#include <cstddef>

#include "formats/base/interval.h"
#include "render/color_map.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Table of a colour map for effects: evenly spaced colours with linear interpolation between them.
/// It differs from color_of by less than half a step of 8-bit sRGB.
class ColorTable {
 public:
  explicit ColorTable(ColorMap map);

  /// Returns the table of a map; it is built at the first call.
  static const ColorTable& of(ColorMap map);

  /// Looks up the colours of a group's values over a range. Values outside get the colour of the
  /// nearer end; a NaN gets the colour of the low end.
  RHORAY_INLINE void look_up(const double* values, const Interval<double>& range, Colors& colors) const {
    const double low = range.lo, width = range.hi - range.lo;
    for (std::size_t i = 0; i < colors.red.size(); ++i) {
      const double share = (values[i] - low) / width;
      const double above = share > 0 ? share : 0;  // written so that a NaN becomes 0
      const double place = (above < 1 ? above : 1) * steps;
      const auto before = static_cast<std::size_t>(place);
      const auto weight = static_cast<float>(place - static_cast<double>(before));
      const std::array<float, 3>&a = colors_[before], &b = colors_[before + 1];
      colors.red[i] = a[0] + weight * (b[0] - a[0]);
      colors.green[i] = a[1] + weight * (b[1] - a[1]);
      colors.blue[i] = a[2] + weight * (b[2] - a[2]);
    }
  }

 private:
  static constexpr std::size_t steps = 512;

  /// The last one twice: the neighbour of a share of 1.
  std::array<std::array<float, 3>, steps + 2> colors_;
};

}  // namespace rhoray::render
