#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>

#include "render/cell/trilinear.h"
#include "tests/render/support/exact.h"

namespace rhoray::tests {

/// 113 bits: decisions that are not certain by far more than the rounding are made in rational
/// numbers.
using Quad = __float128;

/// value - isovalue along the chord of a trilinear cell, in Bernstein coefficients. Its sign is
/// chosen so that it is positive on the side on which the ray starts. Number is Rational (exact) or
/// Quad.
template <class Number>
class ExactChord {
 public:
  using Coefficients = std::array<Number, 4>;

  ExactChord(const render::TrilinearCell& cell, const Vec3& in, const Vec3& out, double isovalue, bool starts_inside)
      : starts_inside_(starts_inside) {
    std::array<Number, 8> f;
    for (std::size_t c = 0; c < 8; ++c) {
      f[c] = Number(cell.corner[c]) - Number(isovalue);
      if (!starts_inside) f[c] = -f[c];
      const Number magnitude = f[c] < 0 ? Number(-f[c]) : f[c];
      band_ = std::max<Number>(band_, magnitude);
    }
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        for (int c = 0; c < 2; ++c) {
          const Number x(a ? out.x : in.x), y(b ? out.y : in.y), z(c ? out.z : in.z);
          const auto between = [](const Number& low, const Number& high, const Number& w) -> Number {
            return low + w * (high - low);
          };
          const Number v00 = between(f[0], f[1], x), v10 = between(f[2], f[3], x), v01 = between(f[4], f[5], x),
                       v11 = between(f[6], f[7], x);
          b_[static_cast<std::size_t>(a + b + c)] += between(between(v00, v10, y), between(v01, v11, y), z);
        }
    b_[1] /= 3, b_[2] /= 3;
    band_ = is_exact ? Number(0) : band_ * Number(1e-30);
  }

  /// Whether the chord starts on its side; nothing where this number type cannot tell.
  std::optional<bool> starts_on_its_side() const { return has_start_side(b_[0]); }

  /// Whether the start side is kept on [0, to]; nothing where this number type cannot tell, or
  /// after `depth` bisections.
  std::optional<bool> keeps_side_until(double to, int depth = 80) const {
    if (to <= 0) return starts_on_its_side();
    return keeps_side(left_of(b_, Number(std::min(to, 1.0))), depth);
  }

  Number value_at(double s) const { return left_of(b_, Number(s))[3]; }

 private:
  static constexpr bool is_exact = std::is_same_v<Number, Rational>;

  /// Zero is inside: it is the start side only for a ray that starts inside.
  std::optional<bool> has_start_side(const Number& v) const {
    if (v > band_) return true;
    if (v < -band_) return false;
    if (is_exact && v == 0) return starts_inside_;
    return std::nullopt;
  }

  static Coefficients left_of(Coefficients c, const Number& s) {
    Coefficients left;
    for (std::size_t n = 0; n < 4; ++n) {
      left[n] = c[0];
      for (std::size_t i = 0; i + n + 1 < 4; ++i) c[i] = c[i] + s * (c[i + 1] - c[i]);
    }
    return left;
  }

  std::optional<bool> keeps_side(const Coefficients& b, int depth) const {
    const std::optional<bool> at_start = has_start_side(b[0]), at_end = has_start_side(b[3]);
    if (at_start == false || at_end == false) return false;
    if (!at_start || !at_end) return std::nullopt;
    if (std::all_of(b.begin(), b.end(), [&](const Number& v) { return has_start_side(v) == true; })) return true;
    if (depth == 0) return std::nullopt;
    const Number half(0.5);
    const Coefficients right = left_of({b[3], b[2], b[1], b[0]}, half);
    const std::optional<bool> before = keeps_side(left_of(b, half), depth - 1);
    if (before != true) return before;
    return keeps_side(right, depth - 1);
  }

  bool starts_inside_;
  Coefficients b_{};
  Number band_{};
};

}  // namespace rhoray::tests
