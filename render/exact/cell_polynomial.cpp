#include "render/exact/cell_polynomial.h"

namespace rhoray::render::exact {

namespace {

/// Linear functions of t on one axis: the distance from the lower plane and to the upper one, and
/// their sum, the width. In units of a power of two.
struct Weights {
  std::array<Whole, 2> from_low, to_high;
  Whole width;
};

Weights weights_of(const Whole& low, const Whole& high, const Whole& start, const Whole& slope) {
  return {{start - low, slope}, {high - start, -slope}, high - low};
}

/// a * to_high + b * from_low: linear interpolation times the width.
template <std::size_t n>
std::array<Whole, n + 1> mix(const std::array<Whole, n>& a, const std::array<Whole, n>& b, const Weights& weights) {
  std::array<Whole, n + 1> result;
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t power = 0; power < 2; ++power)
      result[k + power] += a[k] * weights.to_high[power] + b[k] * weights.from_low[power];
  return result;
}

ScaledPolynomial interpolated(const std::array<double, 8>& corner, double offset,
                              const std::array<Weights, 3>& weights) {
  std::array<double, 9> values{};
  std::copy(corner.begin(), corner.end(), values.begin());
  values[8] = offset;
  const CommonUnit unit(values);
  const Whole whole_offset = unit.whole(offset);
  std::array<std::array<Whole, 1>, 8> f;
  for (std::size_t c = 0; c < 8; ++c) f[c][0] = unit.whole(corner[c]) - whole_offset;
  const auto row = [&](std::size_t c) { return mix(f[c], f[c + 1], weights[0]); };
  const auto low = mix(row(0), row(2), weights[1]), high = mix(row(4), row(6), weights[1]);
  return {{mix(low, high, weights[2])},
          power_of_two(unit.exponent()) / Rational(weights[0].width * weights[1].width * weights[2].width)};
}

}  // namespace

ScaledPolynomial along(const std::array<double, 8>& corner, double offset, const std::array<AxisOfChord, 3>& axes) {
  std::array<Weights, 3> weights;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& [low, high, start, slope] = axes[axis];
    const CommonUnit unit(std::array{low, high, start, slope});
    weights[axis] = weights_of(unit.whole(low), unit.whole(high), unit.whole(start), unit.whole(slope));
  }
  return interpolated(corner, offset, weights);
}

ScaledPolynomial along_unit_cell(const std::array<double, 8>& corner, double offset, const std::array<double, 3>& p0,
                                 const std::array<double, 3>& p1) {
  std::array<Weights, 3> weights;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const CommonUnit unit(std::array{1.0, p0[axis], p1[axis]});
    const Whole start = unit.whole(p0[axis]);
    weights[axis] = weights_of(0, unit.whole(1), start, unit.whole(p1[axis]) - start);
  }
  return interpolated(corner, offset, weights);
}

}  // namespace rhoray::render::exact
