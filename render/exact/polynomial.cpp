#include "render/exact/polynomial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/cell/cubic.h"

namespace rhoray::render::exact {

namespace {

Rational middle(const Rational& a, const Rational& b) {
  return (a + b) / 2;
}

/// Returns the polynomial divided by (t - root) and times a positive number. `root` must be a root.
///
/// With root = n/d in lowest terms, d t - n divides a polynomial with integer coefficients and
/// leaves integer ones (lemma of Gauss).
Polynomial without_root(const Polynomial& p, const Rational& root) {
  const Whole n = numerator(root), d = denominator(root);
  Polynomial quotient;
  Whole carried = 0;
  for (std::size_t k = 3; k > 0; --k) {
    const Whole above = p.c[k] + n * carried;
    carried = above / d;
    quotient.c[k - 1] = carried;
  }
  return quotient;
}

Polynomial without_root_of_any_order(Polynomial p, const Rational& root) {
  while (p.sign_at(root) == 0) p = without_root(p, root);
  return p;
}

/// Bernstein coefficients on [a, b], times one positive number.
using Bernstein = std::array<Whole, 4>;

Bernstein bernstein(const Polynomial& p, const Rational& a, const Rational& b) {
  // With a = n / d and b = (n + m) / d: d^3 p(a + s (b - a)) = sum of c_k (n + s m)^k d^(3 - k).
  const Whole d = denominator(a) * denominator(b);
  const Whole n = numerator(a) * denominator(b);
  const Whole m = numerator(b) * denominator(a) - n;
  const Whole d2 = d * d;
  const Whole c0 = p.c[0] * d2 * d, c1 = p.c[1] * d2, c2 = p.c[2] * d, &c3 = p.c[3];
  // Taylor coefficients at a, by Horner's scheme.
  const Whole e0 = ((c3 * n + c2) * n + c1) * n + c0;
  const Whole e1 = ((3 * c3 * n + 2 * c2) * n + c1) * m;
  const Whole e2 = (3 * c3 * n + c2) * m * m;
  const Whole e3 = c3 * m * m * m;
  return {3 * e0, 3 * e0 + e1, 3 * e0 + 2 * e1 + e2, 3 * (e0 + e1 + e2 + e3)};
}

/// Returns both halves, each times 8.
std::array<Bernstein, 2> halves(const Bernstein& b) {
  const Whole c0 = b[0] + b[1], c1 = b[1] + b[2], c2 = b[2] + b[3];
  const Whole d0 = c0 + c1, d1 = c1 + c2;
  const Whole e = d0 + d1;
  return {{{8 * b[0], 4 * c0, 2 * d0, e}, {e, 2 * d1, 4 * c2, 8 * b[3]}}};
}

/// By Descartes' rule: no root in the open interval when 0, exactly one when 1.
int sign_variations(const Bernstein& b) {
  int variations = 0, last = 0;
  for (const Whole& coefficient : b) {
    const int sign = coefficient.sign();
    if (sign == 0) continue;
    if (last != 0 && sign != last) ++variations;
    last = sign;
  }
  return variations;
}

struct Isolation {
  std::vector<Root> roots;
  std::optional<Rational> hit;  ///< a root that bisection hit exactly; the search ends there
};

void isolate(const Bernstein& b, const Rational& lo, const Rational& hi, Isolation& found) {
  const int variations = sign_variations(b);
  if (variations == 0 || found.hit) return;
  if (variations == 1) {
    found.roots.push_back({lo, hi});
    return;
  }
  const Rational at = middle(lo, hi);
  const auto [left, right] = halves(b);
  if (right[0] == 0) {
    found.hit = at;
    return;
  }
  isolate(left, lo, at, found);
  isolate(right, at, hi, found);
}

/// Converts them to doubles in units of the largest of them.
Cubic in_doubles(const Bernstein& b) {
  std::array<double, 4> mantissa{};
  std::array<long, 4> exponent{};
  long largest = std::numeric_limits<long>::min();
  for (std::size_t k = 0; k < 4; ++k) {
    mantissa[k] = mpz_get_d_2exp(&exponent[k], b[k].backend().data());
    if (mantissa[k] != 0) largest = std::max(largest, exponent[k]);
  }
  Cubic cubic{};
  for (std::size_t k = 0; k < 4; ++k)
    if (mantissa[k] != 0)
      cubic.b[k] = std::ldexp(mantissa[k], static_cast<int>(std::max(exponent[k] - largest, -2000L)));
  return cubic;
}

}  // namespace

int Polynomial::degree() const {
  for (int k = 3; k >= 0; --k)
    if (c[static_cast<std::size_t>(k)] != 0) return k;
  return -1;
}

int Polynomial::sign_at(const Rational& t) const {
  const Whole n = numerator(t), d = denominator(t);
  const Whole d2 = d * d;
  return Whole(((c[3] * n + c[2] * d) * n + c[1] * d2) * n + c[0] * d2 * d).sign();
}

Rational Polynomial::at(const Rational& t) const {
  return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

Polynomial Polynomial::derivative() const {
  return {{c[1], 2 * c[2], 3 * c[3], 0}};
}

Polynomial Polynomial::above(const Rational& level) const {
  const Whole d = denominator(level);
  return {{c[0] * d - numerator(level), c[1] * d, c[2] * d, c[3] * d}};
}

SignChart::SignChart(const Polynomial& polynomial, const Rational& a, const Rational& b)
    : polynomial_(polynomial), simple_(polynomial), a_(a), b_(b) {
  if (polynomial_.degree() < 0) {
    is_zero_ = true;
    if (a_ < b_) pieces_.push_back({0, -1});
    return;
  }
  sign_at_a_ = polynomial_.sign_at(a_);
  find_roots();
  keep_apart();
  if (a_ == b_) return;
  if (roots_.empty() || roots_.front().lo != a_) pieces_.push_back({sign_at_a_, -1});
  for (std::size_t r = 0; r < roots_.size(); ++r) {
    const Rational& next = r + 1 < roots_.size() ? roots_[r + 1].lo : b_;
    if (roots_[r].hi == b_) break;
    pieces_.push_back({polynomial_.sign_at(middle(roots_[r].hi, next)), static_cast<int>(r)});
  }
}

void SignChart::find_roots() {
  const auto take_out = [&](const Rational& root) {
    roots_.push_back({root, root});
    simple_ = without_root_of_any_order(simple_, root);
  };
  if (simple_.sign_at(a_) == 0) take_out(a_);
  if (simple_.sign_at(b_) == 0) take_out(b_);
  if (a_ < b_) {
    add_multiple_root();
    for (;;) {
      if (simple_.degree() < 1) break;
      if (simple_.degree() == 1) {
        const Rational root = Rational(-simple_.c[0], simple_.c[1]);
        if (root > a_ && root < b_) roots_.push_back({root, root});
        break;
      }
      Isolation found;
      isolate(bernstein(simple_, a_, b_), a_, b_, found);
      if (!found.hit) {
        roots_.insert(roots_.end(), found.roots.begin(), found.roots.end());
        break;
      }
      take_out(*found.hit);
    }
  }
}

void SignChart::add_multiple_root() {
  const auto& c = simple_.c;
  std::optional<Rational> root;
  if (simple_.degree() == 2) {
    if (c[1] * c[1] == 4 * c[0] * c[2]) root = Rational(-c[1], 2 * c[2]);
  } else if (simple_.degree() == 3) {
    const Whole discriminant = 18 * c[0] * c[1] * c[2] * c[3] - 4 * c[2] * c[2] * c[2] * c[0] +
                               c[1] * c[1] * c[2] * c[2] - 4 * c[3] * c[1] * c[1] * c[1] -
                               27 * c[3] * c[3] * c[0] * c[0];
    if (discriminant == 0) {
      const Whole spread = c[2] * c[2] - 3 * c[1] * c[3];  // zero when all three roots are one
      root = spread == 0 ? Rational(-c[2], 3 * c[3]) : Rational(9 * c[0] * c[3] - c[1] * c[2]) / Rational(2 * spread);
    }
  }
  if (!root) return;
  if (*root > a_ && *root < b_) roots_.push_back({*root, *root});
  simple_ = without_root_of_any_order(simple_, *root);
}

/// Separates roots that are known as intervals from all others, from a and from b. An exact root
/// may at first be inside the interval of another.
void SignChart::keep_apart() {
  const auto is_free = [&](std::size_t r) {
    const Root& root = roots_[r];
    if (root.lo == a_ || root.hi == b_) return false;
    for (std::size_t other = 0; other < roots_.size(); ++other)
      if (other != r && roots_[other].lo <= root.hi && roots_[other].hi >= root.lo) return false;
    return true;
  };
  for (std::size_t r = 0; r < roots_.size(); ++r)
    while (!roots_[r].is_exact() && !is_free(r)) roots_[r] = halved(roots_[r]);
  std::sort(roots_.begin(), roots_.end(), [](const Root& x, const Root& y) { return x.lo < y.lo; });
}

Root SignChart::halved(const Root& root) const {
  return cut(root, middle(root.lo, root.hi));
}

/// Returns the part that contains the root; `at` is between its ends.
Root SignChart::cut(const Root& root, const Rational& at) const {
  const int sign = simple_.sign_at(at);
  if (sign == 0) return {at, at};
  return sign == simple_.sign_at(root.lo) ? Root{at, root.hi} : Root{root.lo, at};
}

Enclosure SignChart::enclosing_root(int root, double width) const {
  if (root < 0) return enclosing(a_);
  Root around = roots_[static_cast<std::size_t>(root)];
  // `width` may be 0, or far below the distance of neighbouring doubles: then in steps, for only the
  // enclosure shows when it is tight.
  const bool in_steps = width < 0x1p-100;
  for (Rational wanted = Rational(std::min(width, std::numeric_limits<double>::max())) / 2;; wanted /= 16) {
    around = narrowed(around, in_steps ? Rational((around.hi - around.lo) * power_of_two(-64)) : wanted);
    const Enclosure found = enclosing(around.lo, around.hi);
    if (found.width() <= width || is_tight(found)) return found;
    // A root that is itself a double has no tight enclosure but [root, root].
    around = cut(around, Rational(std::nextafter(found.lo, std::numeric_limits<double>::infinity())));
  }
}

/// Guesses in double precision, and accepts a guess when the signs around it are correct.
Root SignChart::narrowed(Root root, const Rational& width) const {
  while (root.hi - root.lo > width) {
    const Rational whole = root.hi - root.lo;
    const int sign_lo = simple_.sign_at(root.lo);
    const Cubic cubic = in_doubles(bernstein(simple_, root.lo, root.hi));
    const bool is_seen = is_inside(cubic.b[0]) != is_inside(cubic.b[3]);
    const double guess = is_seen ? bracketed_root(cubic, 0.0, 1.0, 0.5).s : 0.5;
    const double wanted = Rational(width / whole).convert_to<double>() / 4;
    const double reach = std::clamp(wanted, 0x1p-48, 0.25);
    const Root before = root;
    if (const double s = guess - reach; s > 0) {
      const Rational at = before.lo + whole * Rational(s);
      const int sign = simple_.sign_at(at);
      if (sign == 0) return {at, at};
      (sign == sign_lo ? root.lo : root.hi) = at;
    }
    if (const double s = guess + reach; s < 1) {
      const Rational at = before.lo + whole * Rational(s);
      if (at < root.hi) {
        const int sign = simple_.sign_at(at);
        if (sign == 0) return {at, at};
        (sign == sign_lo ? root.lo : root.hi) = at;
      }
    }
    if (root.hi - root.lo > whole / 4) root = halved(root);
    if (root.is_exact()) return root;
  }
  return root;
}

std::optional<SideChange> first_change(const SignChart& chart, bool starts_inside) {
  const auto& pieces = chart.pieces();
  if (starts_inside) {
    if (chart.sign_at_a() < 0) return SideChange{};
    for (const SignChart::Piece& piece : pieces)
      if (piece.sign < 0) return SideChange{piece.root_before};
    return std::nullopt;
  }
  if (chart.is_zero_throughout() || chart.sign_at_a() > 0) return SideChange{-1, pieces.empty()};
  if (chart.roots().empty()) return std::nullopt;
  const bool goes_on = std::any_of(pieces.begin(), pieces.end(), [](const SignChart::Piece& piece) {
    return piece.root_before == 0 && piece.sign > 0;
  });
  return SideChange{0, !goes_on};
}

}  // namespace rhoray::render::exact
