#include "render/exact/exact_numbers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace rhoray::render::exact {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double largest_double = std::numeric_limits<double>::max();

/// x = mantissa * 2^exponent with an odd mantissa; zero has exponent 0.
struct Parts {
  std::int64_t mantissa = 0;
  int exponent = 0;
};

Parts parts_of(double x) {
  if (x == 0) return {};
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  const std::int64_t mantissa = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa >> zeros, exponent - 53 + zeros};
}

/// x without the digits that a double cannot hold.
double towards_zero(const Rational& x) {
  return mpq_get_d(x.backend().data());
}

}  // namespace

double rounded_down(const Rational& x) {
  const double inner = towards_zero(x);
  if (std::isinf(inner)) return inner > 0 ? largest_double : inner;
  return x.sign() < 0 && x < Rational(inner) ? std::nextafter(inner, -infinity) : inner;
}

double rounded_up(const Rational& x) {
  const double inner = towards_zero(x);
  if (std::isinf(inner)) return inner < 0 ? -largest_double : inner;
  return x.sign() > 0 && x > Rational(inner) ? std::nextafter(inner, infinity) : inner;
}

bool is_tight(const Enclosure& enclosure) {
  return std::nextafter(enclosure.lo, infinity) >= enclosure.hi;
}

CommonUnit::CommonUnit(std::span<const double> numbers) : exponent_(std::numeric_limits<int>::max()) {
  for (const double x : numbers)
    if (x != 0) exponent_ = std::min(exponent_, parts_of(x).exponent);
  if (exponent_ == std::numeric_limits<int>::max()) exponent_ = 0;  // nothing but zeros
}

Whole CommonUnit::whole(double x) const {
  const Parts parts = parts_of(x);
  Whole result = parts.mantissa;
  if (parts.mantissa != 0) result <<= static_cast<unsigned>(parts.exponent - exponent_);
  return result;
}

Rational power_of_two(int exponent) {
  const Whole power = Whole(1) << static_cast<unsigned>(std::abs(exponent));
  return exponent >= 0 ? Rational(power) : Rational(Whole(1), power);
}

}  // namespace rhoray::render::exact
