#pragma once

#include <algorithm>

namespace rhoray::render {

/// A number in [lo, hi], both ends included.
struct Enclosure {
  double lo = 0;
  double hi = 0;

  double width() const { return hi - lo; }
  bool contains(double x) const { return x >= lo && x <= hi; }
};

/// Returns an enclosure of a number that is at least as large as another one, given an enclosure of
/// each. Neither end is below the same end of the other enclosure. The result is at most as wide as
/// the wider of the two.
inline Enclosure not_below(const Enclosure& other, const Enclosure& number) {
  return {std::max(other.lo, number.lo), std::max(other.hi, number.hi)};
}

/// The number that stands for an enclosure, and a bound on its distance from the exact one.
struct Middle {
  double value, error;
  explicit Middle(const Enclosure& enclosure)
      : value(0.5 * enclosure.lo + 0.5 * enclosure.hi),
        error(std::max(value - enclosure.lo, enclosure.hi - value) * (1 + 0x1p-50)) {}
};

/// The uncertainty of the position of an exactly decided crossing: about a millionth of a millionth
/// of a cell.
inline constexpr double exact_width_cells = 0x1p-40;

/// How a decision was reached.
enum class Road {
  filter,  ///< in double precision, with every sign certain
  exact    ///< in rational numbers
};

}  // namespace rhoray::render
