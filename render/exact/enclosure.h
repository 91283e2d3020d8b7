#pragma once

namespace rhoray::render {

/// A number in [lo, hi], both ends included.
struct Enclosure {
  double lo = 0;
  double hi = 0;

  double width() const { return hi - lo; }
  bool contains(double x) const { return x >= lo && x <= hi; }
};

/// How a decision was reached.
enum class Road {
  filter,  ///< in double precision, with every sign certain
  exact    ///< in rational numbers
};

}  // namespace rhoray::render
