#pragma once

#include "render/exact/polynomial.h"

namespace rhoray::render::exact {

/// a + b sqrt(d) with d >= 0: a cubic's value where its derivative is zero.
struct Surd {
  Rational a, b, d;
};

/// Returns -1, 0 or 1 for x < y, x = y or x > y; exact.
int compare(const Surd& x, const Surd& y);

/// At most `width` > 0 wide, or tight (is_tight).
Enclosure enclosing(const Surd& x, double width);

/// The largest value of a polynomial on [a, b] and the smallest t at which it is reached.
struct Maximum {
  Surd value;
  Enclosure at;
};

/// @param width  > 0; `at` is at most this wide, or tight
Maximum largest_value(const Polynomial& polynomial, const Rational& a, const Rational& b, double width);

}  // namespace rhoray::render::exact
