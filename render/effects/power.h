#pragma once

#include <bit>
#include <cstdint>

#include "formats/base/checks.h"

namespace rhoray::render {

/// base to the power of exponent, for a base in [0, 1] and an exponent above 0; 2^-100 where the power is less.
///
/// Relative error below 4e-7 (1 + |log2 of the power|), so absolute error below 6e-7: a step of 8-bit colour is 4e-3.
/// No branches and no tables: the compiler makes it wide.
RHORAY_INLINE float power(float base, float exponent) {
  // base = mantissa * 2^scale, mantissa in [sqrt(1/2), sqrt(2)); its logarithm by the series of artanh.
  constexpr std::int32_t root_of_half = 0x3f3504f3;
  const auto bits = std::bit_cast<std::int32_t>(base);
  const std::int32_t scale = (bits - root_of_half) >> 23;
  const float mantissa = std::bit_cast<float>(bits - scale * (1 << 23));
  const float s = (mantissa - 1) / (mantissa + 1), s2 = s * s;
  const float log2_mantissa =
      s * (2.8853900818F + s2 * (0.9617966939F + s2 * (0.5770780164F + s2 * (0.4121985831F + s2 * 0.3205989F))));
  const float log2_base = static_cast<float>(scale) + log2_mantissa;

  // 2^x = 2^whole * 2^part, part in [-1/2, 1/2]; adding 1.5 * 2^23 rounds to a whole number.
  constexpr float rounder = 12582912;
  const float log2_power = exponent * log2_base;
  const float x = log2_power > -100 ? log2_power : -100;
  const float rounded = x + rounder;
  const float part = x - (rounded - rounder);
  const float power_of_part =
      1 +
      part *
          (0.6931471806F +
           part * (0.2402264791F +
                   part * (0.0555033248F + part * (0.0096184373F + part * (0.00133988744F + part * 0.00015353362F)))));
  const std::int32_t whole = std::bit_cast<std::int32_t>(rounded) - std::bit_cast<std::int32_t>(rounder);
  return power_of_part * std::bit_cast<float>((whole + 127) << 23);
}

}  // namespace rhoray::render
