#pragma once

#include <optional>
#include <vector>

#include "tests/render/support/exact.h"

namespace rhoray::tests {

/// Coefficients of powers of t, in increasing order; no leading zeros.
using Coefficients = std::vector<Rational>;

inline Coefficients trimmed(Coefficients p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
  return p;
}

inline Rational value_of(const Coefficients& p, const Rational& t) {
  Rational sum = 0;
  for (auto c = p.rbegin(); c != p.rend(); ++c) sum = sum * t + *c;
  return sum;
}

inline Coefficients derivative_of(const Coefficients& p) {
  Coefficients d;
  for (std::size_t k = 1; k < p.size(); ++k) d.push_back(p[k] * static_cast<long>(k));
  return d;
}

struct Division {
  Coefficients quotient, rest;
};
inline Division divide(Coefficients p, const Coefficients& by) {
  Division result;
  result.quotient.resize(p.size() >= by.size() ? p.size() - by.size() + 1 : 0);
  while (p.size() >= by.size()) {
    const std::size_t shift = p.size() - by.size();
    const Rational factor = p.back() / by.back();
    result.quotient[shift] = factor;
    for (std::size_t k = 0; k < by.size(); ++k) p[shift + k] -= factor * by[k];
    p.pop_back();
    p = trimmed(std::move(p));
  }
  result.rest = std::move(p);
  return result;
}

/// Returns the polynomial of degree 3 through four points.
template <class Function>
Coefficients cubic_through(const Function& f) {
  Coefficients sum(4, Rational(0));
  for (int i = 0; i < 4; ++i) {
    Coefficients basis{Rational(1)};
    Rational scale = 1;
    for (int j = 0; j < 4; ++j) {
      if (j == i) continue;
      Coefficients next(basis.size() + 1, Rational(0));
      for (std::size_t k = 0; k < basis.size(); ++k) {
        next[k + 1] += basis[k];
        next[k] -= basis[k] * j;
      }
      basis = next;
      scale *= i - j;
    }
    const Rational value = f(Rational(i));
    for (std::size_t k = 0; k < 4; ++k) sum[k] += basis[k] * value / scale;
  }
  return trimmed(sum);
}

/// An independent method for the roots and signs of a polynomial on [a, b]: Sturm's theorem, with
/// numbers of another library.
class SturmChart {
 public:
  SturmChart(const Coefficients& p, const Rational& a, const Rational& b) : p_(trimmed(p)), a_(a), b_(b) {
    if (p_.empty()) return;
    Coefficients common = p_, other = derivative_of(p_);
    while (!other.empty()) {
      Coefficients rest = divide(common, other).rest;
      common = std::move(other);
      other = std::move(rest);
    }
    square_free_ = divide(p_, common).quotient;
    chain_ = {square_free_, derivative_of(square_free_)};
    while (!chain_.back().empty()) {
      Coefficients rest = divide(chain_[chain_.size() - 2], chain_.back()).rest;
      for (Rational& c : rest) c = -c;
      chain_.push_back(std::move(rest));
    }
    if (value_of(square_free_, a_) == 0) roots_.push_back({a_, a_});
    if (a_ < b_) isolate(a_, b_);
  }

  struct Root {
    Rational lo, hi;  ///< lo < root <= hi, or the root itself
  };
  bool is_zero() const { return p_.empty(); }
  const std::vector<Root>& roots() const { return roots_; }

  struct Change {
    Root at;
    bool touches = false;
  };
  std::optional<Change> first_change(bool starts_inside) const {
    const int start = sign_of(value_of(p_, a_));
    if (starts_inside) {
      if (start < 0) return Change{{a_, a_}};
      for (std::size_t r = 0; r < roots_.size(); ++r)
        if (const auto sign = sign_behind(r); sign && *sign < 0) return Change{roots_[r]};
      return std::nullopt;
    }
    if (is_zero() || start > 0) return Change{{a_, a_}, a_ == b_};
    if (roots_.empty()) return std::nullopt;
    return Change{roots_[0], sign_behind(0).value_or(-1) < 0};
  }

 private:
  std::size_t variations(const Rational& t) const {
    std::size_t count = 0;
    int last = 0;
    for (const Coefficients& p : chain_) {
      const int sign = sign_of(value_of(p, t));
      if (sign == 0) continue;
      if (last != 0 && sign != last) ++count;
      last = sign;
    }
    return count;
  }

  void isolate(const Rational& lo, const Rational& hi) {
    const std::size_t count = variations(lo) - variations(hi);  // roots in (lo, hi]
    if (count == 0) return;
    if (count == 1 && hi - lo < Rational(1) / (boost::multiprecision::cpp_int(1) << 40)) {
      roots_.push_back(value_of(square_free_, hi) == 0 ? Root{hi, hi} : Root{lo, hi});
      return;
    }
    const Rational middle = (lo + hi) / 2;
    isolate(lo, middle);
    isolate(middle, hi);
  }

  /// Returns nothing for a root at b.
  std::optional<int> sign_behind(std::size_t r) const {
    if (roots_[r].lo == b_) return std::nullopt;
    if (roots_[r].hi == b_) return sign_of(value_of(p_, b_));
    const Rational next = r + 1 < roots_.size() ? roots_[r + 1].lo : b_;
    // Neighbours share an end only where two roots are closer than 2^-40; then the end is between
    // them.
    return sign_of(value_of(p_, (roots_[r].hi + next) / 2));
  }

  Coefficients p_, square_free_;
  std::vector<Coefficients> chain_;
  Rational a_, b_;
  std::vector<Root> roots_;
};

/// True when an enclosure in doubles contains a root, up to the width to which the chart knows it.
inline bool holds(double lo, double hi, const SturmChart::Root& root) {
  return exact(lo) <= root.hi && exact(hi) >= root.lo;
}

}  // namespace rhoray::tests
