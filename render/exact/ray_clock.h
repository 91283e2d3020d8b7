#pragma once

#include "render/exact/ball.h"
#include "render/exact/cell_polynomial.h"
#include "render/exact/grid_source.h"
#include "render/traverse/ray.h"

namespace rhoray::render::exact {

/// A ray parameter: a given double, or the time at which a plane is passed.
struct Time {
  Ball at;
  int axis = -1;  ///< -1: the double at.middle
  std::int64_t plane = 0;
};

/// Times at which a ray passes the planes of a grid: in double precision where that decides, else
/// exactly.
class RayClock {
 public:
  RayClock(const ExactGridSource& grid, const Ray& ray);

  /// +1, -1, or 0 on an axis along which the ray does not move.
  int step(int axis) const { return step_[axis]; }

  Time at_double(double t) const { return {{t, 0}, -1, 0}; }

  /// Only for an axis along which the ray moves.
  Time at_plane(int axis, std::int64_t plane) const;
  Time entry(int axis, std::int64_t cell) const { return at_plane(axis, step_[axis] > 0 ? cell : cell + 1); }
  Time exit(int axis, std::int64_t cell) const { return at_plane(axis, step_[axis] > 0 ? cell + 1 : cell); }

  /// Returns -1, 0 or 1 if a is before, at or behind b.
  int compare(const Time& a, const Time& b) const;

  Rational exact(const Time& time) const;

  /// Returns the cell on one axis at a time. A plane is passed at the moment when the ray meets it;
  /// from the last plane on it is the last cell.
  std::int64_t cell_at(int axis, const Time& time) const;

  /// Returns the ray in a cell, on one axis.
  AxisOfChord chord(int axis, std::int64_t cell) const;

  /// Returns the position in a cell on one axis, in [0, 1], at a time when the ray is in the closed
  /// cell.
  Ball place(int axis, std::int64_t cell, const Time& time) const;

  std::int64_t exact_comparisons() const { return exact_comparisons_; }

 private:
  const ExactGridSource& grid_;
  Index3 cell_count_;
  Vec3 origin_, direction_;
  int step_[3];
  mutable std::int64_t exact_comparisons_ = 0;
};

}  // namespace rhoray::render::exact
