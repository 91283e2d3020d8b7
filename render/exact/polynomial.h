#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/exact/exact_numbers.h"

namespace rhoray::render::exact {

/// A polynomial of degree 3 at most with whole coefficients: c[k] belongs to t^k. A rational polynomial times its
/// denominators has the same roots and the same signs.
struct Polynomial {
  std::array<Whole, 4> c;

  /// -1 for the polynomial that is zero everywhere.
  int degree() const;

  int sign_at(const Rational& t) const;
  Rational at(const Rational& t) const;
  Polynomial derivative() const;

  /// The polynomial times a positive number and less `level` times that number: positive where this is above `level`.
  Polynomial above(const Rational& level) const;
};

/// Where a polynomial is zero: at lo, where lo = hi; else at exactly one place between them, and at neither.
struct Root {
  Rational lo, hi;

  bool is_exact() const { return lo == hi; }
};

/// The sign chart of a polynomial on [a, b]: its distinct roots there, rising, and its sign between them.
///
/// Multiple roots of a cubic with rational coefficients are rational, so they are found by formula and divided out.
/// What is left has simple roots only, which Descartes' rule in Bernstein form isolates by halving (Collins and Akritas
/// 1976; in Bernstein form Lane and Riesenfeld 1981): no tolerance, and it always ends.
class SignChart {
 public:
  /// Needs a <= b.
  SignChart(const Polynomial& polynomial, const Rational& a, const Rational& b);

  /// Then there are no single roots, and the one piece has sign 0.
  bool is_zero_throughout() const { return is_zero_; }

  const std::vector<Root>& roots() const { return roots_; }

  /// A part of (a, b) without roots. There is none when a = b.
  struct Piece {
    int sign;
    int root_before;  ///< index of the root where it starts; -1 where it starts at a
  };
  const std::vector<Piece>& pieces() const { return pieces_; }

  int sign_at_a() const { return sign_at_a_; }

  /// Around a root, or around a for -1: at most `width` > 0 wide, or tight (is_tight).
  Enclosure enclosing_root(int root, double width) const;

 private:
  void find_roots();
  void add_multiple_root();
  void keep_apart();
  Root narrowed(Root root, const Rational& width) const;
  Root halved(const Root& root) const;
  Root cut(const Root& root, const Rational& at) const;

  Polynomial polynomial_;
  Polynomial simple_;  ///< the polynomial without the roots that are known exactly
  Rational a_, b_;
  bool is_zero_ = false;
  int sign_at_a_ = 0;
  std::vector<Root> roots_;
  std::vector<Piece> pieces_;
};

/// Where the side changes along [a, b]; inside is where the polynomial is not negative.
struct SideChange {
  int root = -1;         ///< index of the root; -1: at a, which lies on the other side already
  bool touches = false;  ///< from outside: inside at this one point of [a, b] only
};

/// From outside the first point that is inside; from inside the infimum of the points that are outside. Nothing when
/// the side stays.
std::optional<SideChange> first_change(const SignChart& chart, bool starts_inside);

}  // namespace rhoray::render::exact
