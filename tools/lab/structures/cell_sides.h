#pragma once

#include <array>
#include <cstddef>

#include "formats/base/vector.h"

namespace rhoray::study {

/// Tests which boxes a tetrahedron touches. Finds all boxes that it touches, and none that is
/// farther away than 1e-6 of the box's edge.
///
/// A box and a tetrahedron are disjoint exactly when they are separated along a box axis, a face's
/// normal, or a box axis times an edge. The tetrahedron's extent along these 25 directions is kept,
/// so a box costs a product with each. A direction is only a witness: its own rounding does no
/// harm.
class CellSides {
 public:
  explicit CellSides(const std::array<std::array<double, 3>, 4>& points);

  /// @param half  half the box's edges
  bool touches(const Vec3& center, const Vec3& half) const;

 private:
  static constexpr std::size_t count = 25;
  std::array<double, count> x_, y_, z_;                 ///< directions
  std::array<double, count> size_x_, size_y_, size_z_;  ///< without signs
  std::array<double, count> lo_, hi_;                   ///< extent of the tetrahedron along them
};

}  // namespace rhoray::study
