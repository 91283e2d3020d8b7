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

/// Returns the largest double that is not above x; -infinity if there is none.
double rounded_down(const Rational& x);

/// Returns the smallest double that is not below x; infinity if there is none.
double rounded_up(const Rational& x);

inline Enclosure enclosing(const Rational& lo, const Rational& hi) {
  return {rounded_down(lo), rounded_up(hi)};
}

/// Returns the adjacent doubles around x, or x itself twice.
inline Enclosure enclosing(const Rational& x) {
  return enclosing(x, x);
}

/// True when no finer enclosure in doubles could be much better: its ends are the same or
/// neighbours.
bool is_tight(const Enclosure& enclosure);

/// Expresses several finite doubles as integers in one unit, a power of two: x = whole(x) *
/// 2^exponent.
class CommonUnit {
 public:
  explicit CommonUnit(std::span<const double> numbers);

  /// @param x  one of the numbers, or zero
  Whole whole(double x) const;

  int exponent() const { return exponent_; }

 private:
  int exponent_;
};

/// Returns 2^exponent.
Rational power_of_two(int exponent);

}  // namespace rhoray::render::exact
