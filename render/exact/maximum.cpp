#include "render/exact/maximum.h"

#include <algorithm>

#include "formats/base/checks.h"

namespace rhoray::render::exact {

namespace {

int sign_of_sum(const Rational& a, const Rational& b, const Rational& d) {
  const int sign_a = a.sign(), sign_b = d.sign() == 0 ? 0 : b.sign();
  if (sign_a == 0) return sign_b;
  if (sign_b == 0 || sign_a == sign_b) return sign_a;
  const Rational rest = a * a - b * b * d;  // a and b sqrt(d) have opposite signs
  return rest.sign() == 0 ? 0 : rest.sign() > 0 ? sign_a : sign_b;
}

/// The sign of b sqrt(d).
int sign_of_root(const Rational& b, const Rational& d) {
  return d.sign() == 0 ? 0 : b.sign();
}

/// Returns the value at which the derivative of a cubic is zero and decreasing.
Surd value_at_local_maximum(const Polynomial& p) {
  // The derivative a t^2 + b t + c is zero at t = (-b -+ sqrt(b^2 - 4 a c)) / (2 a); it decreases
  // there for the minus, whatever the sign of a. By division, p = derivative * (linear) + slope t +
  // base.
  const Rational a(3 * p.c[3]), b(2 * p.c[2]), c(p.c[1]), p2(p.c[2]), p3(p.c[3]);
  const Rational slope = 2 * (c - p2 * p2 / (3 * p3)) / 3;
  const Rational base = Rational(p.c[0]) - c * p2 / (9 * p3);
  return {base - slope * b / (2 * a), -slope / (2 * a), b * b - 4 * a * c};
}

}  // namespace

int compare(const Surd& x, const Surd& y) {
  // The sign of (a + b sqrt(d)) + c sqrt(e): where both parts have opposite signs, the larger
  // square decides.
  const Rational a = x.a - y.a, c = -y.b;
  const int left = sign_of_sum(a, x.b, x.d), right = sign_of_root(c, y.d);
  if (left == 0) return right;
  if (right == 0 || left == right) return left;
  const int larger = sign_of_sum(a * a + x.b * x.b * x.d - c * c * y.d, 2 * a * x.b, x.d);
  return larger == 0 ? 0 : larger > 0 ? left : right;
}

Enclosure enclosing(const Surd& x, double width) {
  if (sign_of_root(x.b, x.d) == 0) return enclosing(x.a);
  // sqrt(n / m) = sqrt(n m) / m, and sqrt(n m) from integers with more and more binary digits.
  const Whole m = denominator(x.d), radicand = numerator(x.d) * m;
  for (unsigned digits = 64;; digits *= 2) {
    const Whole scaled = radicand << (2 * digits);
    const Whole floor = sqrt(scaled);
    const Rational unit = Rational(Whole(1), m << digits);
    const Rational lo = x.a + x.b * unit * floor, hi = x.a + x.b * unit * (floor + (floor * floor == scaled ? 0 : 1));
    const Enclosure found = enclosing(std::min(lo, hi), std::max(lo, hi));
    if (found.width() <= width || is_tight(found)) return found;
  }
}

Maximum largest_value(const Polynomial& polynomial, const Rational& a, const Rational& b, double width) {
  const Rational at_a = polynomial.at(a), at_b = polynomial.at(b);
  const Rational& of_ends = std::max(at_a, at_b);
  const SignChart above_ends(polynomial.above(of_ends), a, b);
  const bool ends_win = std::all_of(above_ends.pieces().begin(), above_ends.pieces().end(),
                                    [](const SignChart::Piece& piece) { return piece.sign <= 0; });
  if (ends_win) {
    return {{of_ends, 0, 0}, above_ends.enclosing_root(above_ends.is_zero_throughout() ? -1 : 0, width)};
  }
  const SignChart slope(polynomial.derivative(), a, b);
  for (std::size_t p = 1; p < slope.pieces().size(); ++p) {
    if (!(slope.pieces()[p - 1].sign > 0 && slope.pieces()[p].sign < 0)) continue;
    const int root = slope.pieces()[p].root_before;
    const Root& at = slope.roots()[static_cast<std::size_t>(root)];
    return {at.is_exact() ? Surd{polynomial.at(at.lo), 0, 0} : value_at_local_maximum(polynomial),
            slope.enclosing_root(root, width)};
  }
  RHORAY_CHECK(false && "a value above both ends has a rise and a fall");
  return {};
}

}  // namespace rhoray::render::exact
