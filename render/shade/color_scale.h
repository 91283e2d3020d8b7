#pragma once

#include <bit>
#include <cstdint>

#include "formats/base/interval.h"
#include "render/color_map.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Returns the logarithm to base 2, within 1e-12. NaN and numbers below 2^-1022 count as 2^-1022.
///
/// It uses only operations that IEEE 754 rounds exactly, so it is the same on every machine.
RHORAY_INLINE double log2_of(double number) {
  const double above = number > 0x1p-1022 ? number : 0x1p-1022;  // written so that a NaN becomes small
  // above = mantissa * 2^scale, mantissa in [sqrt(1/2), sqrt(2)); its logarithm is computed by the
  // artanh series.
  constexpr std::int64_t root_of_half = 0x3fe6a09e667f3bcd;
  const auto bits = std::bit_cast<std::int64_t>(above);
  const std::int64_t scale = (bits - root_of_half) >> 52;
  const double mantissa = std::bit_cast<double>(bits - scale * (std::int64_t{1} << 52));
  const double s = (mantissa - 1) / (mantissa + 1), s2 = s * s;
  const double series =
      1 +
      s2 * (1.0 / 3 + s2 * (1.0 / 5 + s2 * (1.0 / 7 + s2 * (1.0 / 9 + s2 * (1.0 / 11 + s2 * (1.0 / 13 + s2 / 15))))));
  return static_cast<double>(scale) + 2.8853900817779268 * s * series;
}

/// Replaces each position in a range by the position in the map of its band's colour, as
/// position_in_map does.
RHORAY_INLINE void put_into_bands(int levels, double* positions) {
  const double count = levels, last = count - 1;
  for (std::size_t i = 0; i < RayBatch::group_size; ++i) {
    const double place = positions[i] * count;
    const double above = place > 0 ? place : 0;  // written so that a NaN becomes 0
    const auto band = static_cast<double>(static_cast<std::int32_t>(above < last ? above : last));
    positions[i] = band / last;
  }
}

/// Numbers of a group, and the range over which they are spread evenly.
struct EvenNumbers {
  const double* numbers;
  Interval<double> range;
};

/// Returns a group's values and their range if the scale spreads them evenly, else positions in the
/// map, which go from 0 to 1.
/// @param positions  room for a group
RHORAY_INLINE EvenNumbers spread_evenly(const ColorScale& scale, const Interval<double>& range, const double* values,
                                        double* positions) {
  if (!scale.is_logarithmic && scale.levels == 0) return {values, range};
  if (scale.is_logarithmic) {
    const double low = log2_of(range.lo), width = log2_of(range.hi) - low;
    for (std::size_t i = 0; i < RayBatch::group_size; ++i) positions[i] = (log2_of(values[i]) - low) / width;
  } else {
    const double low = range.lo, width = range.hi - range.lo;
    for (std::size_t i = 0; i < RayBatch::group_size; ++i) positions[i] = (values[i] - low) / width;
  }
  if (scale.levels > 0) put_into_bands(scale.levels, positions);
  return {positions, {.lo = 0, .hi = 1}};
}

}  // namespace rhoray::render
