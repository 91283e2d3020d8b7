#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/exact/exact_numbers.h"

namespace rhoray::render::exact {

/// A polynomial of degree 3 at most with integer coefficients: c[k] belongs to t^k. A rational
/// polynomial times its denominators has the same roots and the same signs.
struct Polynomial {
  std::array<Whole, 4> c;

  /// Returns -1 for the polynomial that is zero everywhere.
  int degree() const;

  int sign_at(const Rational& t) const;
  Rational at(const Rational& t) const;
  Polynomial derivative() const;

  /// Returns the polynomial minus `level`, times a positive number: positive where this polynomial
  /// is above `level`.
  Polynomial above(const Rational& level) const;
};

/// A root of a polynomial. If lo = hi, it is at lo. Otherwise there is exactly one root between
/// them, and none at either end.
struct Root {
  Rational lo, hi;

  bool is_exact() const { return lo == hi; }
};

/// The sign chart of a polynomial on [a, b]: its distinct roots there, in increasing order, and its
/// sign between them.
///
/// Multiple roots of a cubic with rational coefficients are rational, so they are found by formula
/// and divided out. The rest has simple roots only, which Descartes' rule in Bernstein form
/// isolates by bisection (Collins and Akritas 1976; in Bernstein form Lane and Riesenfeld 1981): no
/// tolerance, and it always terminates.
class SignChart {
 public:
  /// Requires a <= b.
  SignChart(const Polynomial& polynomial, const Rational& a, const Rational& b);

  /// If true, there are no single roots, and the one piece has sign 0.
  bool is_zero_throughout() const { return is_zero_; }

  const std::vector<Root>& roots() const { return roots_; }

  /// A part of (a, b) without roots. There is none when a = b.
  struct Piece {
    int sign;
    int root_before;  ///< index of the root where it starts; -1 when it starts at a
  };
  const std::vector<Piece>& pieces() const { return pieces_; }

  int sign_at_a() const { return sign_at_a_; }

  /// Returns an enclosure of a root, or of a for -1: at most `width` >= 0 wide, or tight (is_tight).
  Enclosure enclosing_root(int root, double width) const;

 private:
  void find_roots();
  void add_multiple_root();
  void keep_apart();
  Root narrowed(Root root, const Rational& width) const;
  Root halved(const Root& root) const;
  Root cut(const Root& root, const Rational& at) const;

  Polynomial polynomial_;
  Polynomial simple_;  ///< the polynomial divided by its exactly known roots
  Rational a_, b_;
  bool is_zero_ = false;
  int sign_at_a_ = 0;
  std::vector<Root> roots_;
  std::vector<Piece> pieces_;
};

/// Where the side changes along [a, b]; inside is where the polynomial is not negative.
struct SideChange {
  int root = -1;         ///< index of the root; -1: at a, which is on the other side already
  bool touches = false;  ///< from outside: inside at this one point of [a, b] only
};

/// From outside it is the first point that is inside; from inside the infimum of the points that
/// are outside. Returns nothing when the side does not change.
std::optional<SideChange> first_change(const SignChart& chart, bool starts_inside);

}  // namespace rhoray::render::exact
