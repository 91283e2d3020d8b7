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
