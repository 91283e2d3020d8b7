#pragma once

#include <boost/multiprecision/gmp.hpp>
#include <span>

#include "render/exact/enclosure.h"

namespace rhoray::render::exact {

using Whole = boost::multiprecision::mpz_int;
using Rational = boost::multiprecision::mpq_rational;

/// -1, 0 or 1.
inline int sign_of(const Whole& x) {
  return x.sign();
}
inline int sign_of(const Rational& x) {
  return x.sign();
}

/// The largest double that is not above x, -infinity where there is none.
double rounded_down(const Rational& x);

/// The smallest double that is not below x, infinity where there is none.
double rounded_up(const Rational& x);

inline Enclosure enclosing(const Rational& lo, const Rational& hi) {
  return {rounded_down(lo), rounded_up(hi)};
}

/// The doubles next to one another around x, or x itself twice.
inline Enclosure enclosing(const Rational& x) {
  return enclosing(x, x);
}

/// An enclosure that no finer one in doubles could better by much: its ends are the same or neighbours.
bool is_tight(const Enclosure& enclosure);

/// Several finite doubles as whole numbers of one unit, a power of two: x = whole(x) * 2^exponent.
class CommonUnit {
 public:
  explicit CommonUnit(std::span<const double> numbers);

  /// @param x  one of the numbers, or zero
  Whole whole(double x) const;

  int exponent() const { return exponent_; }

 private:
  int exponent_;
};

/// 2^exponent.
Rational power_of_two(int exponent);

}  // namespace rhoray::render::exact
