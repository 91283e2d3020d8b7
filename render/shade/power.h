#pragma once

#include <bit>
#include <cstdint>

#include "render/shade/lanes.h"

namespace rhoray::render {

/// Returns base to the power of exponent, for a base in [0, 1] and an exponent above 0; 2^-100
/// where the power is less.
///
/// The relative error is below 4e-7 (1 + |log2 of the power|), so the absolute error is below 6e-7;
/// a step of 8-bit colour is 4e-3. There are no branches and no tables, so the compiler can
/// vectorize it.
RHORAY_INLINE float power(float base, float exponent) {
  // base = mantissa * 2^scale, mantissa in [sqrt(1/2), sqrt(2)); its logarithm is computed by the
  // artanh series.
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

/// Returns the exponent if raise_to_whole() is faster for it than power(), else 0.
RHORAY_INLINE unsigned short_whole_exponent(double exponent) {
  if (!(exponent >= 1 && exponent <= 1024)) return 0;
  const auto whole = static_cast<unsigned>(exponent);
  return whole == exponent ? whole : 0;
}

/// Raises numbers in [0, 1] to a whole exponent above 0 by repeated squaring; exactly 0 for 0 and 1
/// for 1.
///
/// The distance d from 1 is squared instead of the number: (1 - d)^2 = 1 - d (2 - d). The error of
/// squared numbers would grow with the exponent (1e-6 for x^40, 2e-5 for x^1000); this way it is
/// below 3e-7. The error is absolute: powers are multiples of 2^-24. No result is below 0 or above
/// 1. In d (2 - d) only 2 - d is rounded, by 2^-24 at most, so the product is at most 1 + 2^-24,
/// which is rounded to 1. The same holds for d + y (1 - d), for any y in [0, 1].
RHORAY_INLINE void raise_to_whole(const Lanes& bases, unsigned exponent, Lanes& powers) {
  Lanes y, d;
  for (std::size_t i = 0; i < bases.size(); ++i) y[i] = d[i] = 1 - bases[i];
  unsigned bit = std::bit_floor(exponent);
  while (bit >>= 1)
    if (exponent & bit)
      for (std::size_t i = 0; i < d.size(); ++i) {
        const float squared = d[i] * (2 - d[i]);
        d[i] = squared + y[i] * (1 - squared);
      }
    else
      for (std::size_t i = 0; i < d.size(); ++i) d[i] *= 2 - d[i];
  for (std::size_t i = 0; i < d.size(); ++i) powers[i] = 1 - d[i];
}

/// Raises numbers in [0, 1] to an exponent above 0; the absolute error is below 6e-7.
RHORAY_INLINE void raise(const Lanes& bases, double exponent, Lanes& powers) {
  if (const unsigned whole = short_whole_exponent(exponent)) return raise_to_whole(bases, whole, powers);
  for (std::size_t i = 0; i < bases.size(); ++i) powers[i] = power(bases[i], static_cast<float>(exponent));
}

}  // namespace rhoray::render
