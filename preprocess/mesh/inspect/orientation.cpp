#include "preprocess/mesh/inspect/orientation.h"

#include <algorithm>
#include <cmath>

namespace rhoray::preprocess {
namespace {

/// An unevaluated sum of doubles, ascending in magnitude, no two of which overlap. It represents
/// any sum or product of doubles exactly. Storage is in place: no expansion here has more terms
/// than the determinant, three times 64.
class Expansion {
 public:
  Expansion() = default;
  explicit Expansion(double term) { push_back(term); }
  Expansion(const Expansion& other) : size_(other.size_) { std::copy(other.begin(), other.end(), terms_.begin()); }
  Expansion& operator=(const Expansion& other) {
    std::copy(other.begin(), other.end(), terms_.begin());
    size_ = other.size_;
    return *this;
  }
  ~Expansion() = default;

  void push_back(double term) { terms_[size_++] = term; }
  bool empty() const { return size_ == 0; }
  double back() const { return terms_[size_ - 1]; }
  double* begin() { return terms_.data(); }
  double* end() { return terms_.data() + size_; }
  const double* begin() const { return terms_.data(); }
  const double* end() const { return terms_.data() + size_; }

 private:
  std::array<double, 192> terms_;  // only the first ones are ever read
  std::size_t size_ = 0;
};

struct TwoParts {
  double high, low;
};

TwoParts two_sum(double a, double b) {
  const double high = a + b;
  const double b_part = high - a;
  return {high, (a - (high - b_part)) + (b - b_part)};
}

TwoParts two_product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}

/// Shewchuk's GROW-EXPANSION, without zeros.
Expansion plus(const Expansion& e, double b) {
  Expansion sum;
  double carried = b;
  for (const double term : e) {
    const TwoParts parts = two_sum(carried, term);
    if (parts.low != 0) sum.push_back(parts.low);
    carried = parts.high;
  }
  if (carried != 0) sum.push_back(carried);
  return sum;
}

Expansion plus(Expansion e, const Expansion& f) {
  for (const double term : f) e = plus(e, term);
  return e;
}

Expansion times(const Expansion& e, const Expansion& f) {
  Expansion product;
  for (const double a : e)
    for (const double b : f) {
      const TwoParts parts = two_product(a, b);
      product = plus(plus(product, parts.low), parts.high);
    }
  return product;
}

Expansion negative(Expansion e) {
  for (double& term : e) term = -term;
  return e;
}

Expansion difference(double a, double b) {
  return plus(Expansion(b == 0 ? 0.0 : -b), a);
}

int sign_of(double value) {
  return (value > 0) - (value < 0);
}

int exact_orientation(const std::array<double, 3>& p0, const std::array<double, 3>& p1, const std::array<double, 3>& p2,
                      const std::array<double, 3>& p3) {
  std::array<Expansion, 3> a, b, c;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    a[axis] = difference(p1[axis], p0[axis]);
    b[axis] = difference(p2[axis], p0[axis]);
    c[axis] = difference(p3[axis], p0[axis]);
  }
  Expansion determinant;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
    const Expansion minor = plus(times(a[next], b[last]), negative(times(a[last], b[next])));
    determinant = plus(determinant, times(minor, c[axis]));
  }
  return determinant.empty() ? 0 : sign_of(determinant.back());
}

}  // namespace

int orientation(const std::array<double, 3>& p0, const std::array<double, 3>& p1, const std::array<double, 3>& p2,
                const std::array<double, 3>& p3) {
  double determinant = 0, magnitude = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
    const double forward = (p1[next] - p0[next]) * (p2[last] - p0[last]);
    const double backward = (p1[last] - p0[last]) * (p2[next] - p0[next]);
    const double height = p3[axis] - p0[axis];
    determinant += (forward - backward) * height;
    magnitude += (std::abs(forward) + std::abs(backward)) * std::abs(height);
  }
  // Shewchuk's bound for this order of operations is (7 + 56 e) e of the magnitude, e = 2^-53; 8 e
  // is above it.
  constexpr double relative_error = 0x1p-50;
  if (std::abs(determinant) > relative_error * magnitude) return sign_of(determinant);
  return exact_orientation(p0, p1, p2, p3);
}

}  // namespace rhoray::preprocess
