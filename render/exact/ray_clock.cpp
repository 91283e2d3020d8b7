#include "render/exact/ray_clock.h"

#include <algorithm>
#include <cmath>

namespace rhoray::render::exact {

RayClock::RayClock(const ExactGridSource& grid, const Ray& ray)
    : grid_(grid), cell_count_(grid.cell_count()), origin_(ray.origin), direction_(ray.direction) {
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = 1 / direction_[axis];
    step_[axis] = !std::isfinite(inverse) ? 0 : inverse > 0 ? 1 : -1;
    if (step_[axis] == 0) direction_[axis] = 0;
  }
}

Time RayClock::at_plane(int axis, std::int64_t plane) const {
  const Ball distance = Ball{grid_.plane(axis, plane)} - Ball{origin_[axis]};
  return {distance / Ball{direction_[axis]}, axis, plane};
}

int RayClock::compare(const Time& a, const Time& b) const {
  if (a.axis >= 0 && a.axis == b.axis) {
    const std::int64_t ahead = (a.plane - b.plane) * step_[a.axis];
    return ahead > 0 ? 1 : ahead < 0 ? -1 : 0;
  }
  if (a.axis < 0 && b.axis < 0) return a.at.middle < b.at.middle ? -1 : a.at.middle > b.at.middle ? 1 : 0;
  if (const int sign = (a.at - b.at).sign(); sign != 0) return sign;
  ++exact_comparisons_;
  return sign_of(Rational(exact(a) - exact(b)));
}

Rational RayClock::exact(const Time& time) const {
  if (time.axis < 0) return Rational(time.at.middle);
  return (Rational(grid_.plane(time.axis, time.plane)) - Rational(origin_[time.axis])) /
         Rational(direction_[time.axis]);
}

std::int64_t RayClock::cell_at(int axis, const Time& time) const {
  const std::int64_t count = cell_count_[axis];
  const double position = origin_[axis] + (step_[axis] == 0 ? 0 : time.at.middle * direction_[axis]);
  std::int64_t below = 0, beyond = count;
  while (beyond - below > 1) {
    const std::int64_t middle = below + (beyond - below) / 2;
    (grid_.plane(axis, middle) <= position ? below : beyond) = middle;
  }
  if (step_[axis] == 0) return below;
  // So far in double precision; the comparisons with planes decide.
  const int step = step_[axis];
  const std::int64_t nearest = step > 0 ? 0 : count - 1, furthest = step > 0 ? count - 1 : 0;
  while (below != nearest && compare(entry(axis, below), time) > 0) below -= step;
  while (below != furthest && compare(exit(axis, below), time) <= 0) below += step;
  return below;
}

AxisOfChord RayClock::chord(int axis, std::int64_t cell) const {
  return {grid_.plane(axis, cell), grid_.plane(axis, cell + 1), origin_[axis], direction_[axis]};
}

Ball RayClock::place(int axis, std::int64_t cell, const Time& time) const {
  if (time.axis == axis && (time.plane == cell || time.plane == cell + 1)) return {time.plane == cell ? 0.0 : 1.0, 0};
  Ball position{origin_[axis]};
  if (step_[axis] != 0) position = position + time.at * Ball{direction_[axis]};
  const Ball low{grid_.plane(axis, cell)}, high{grid_.plane(axis, cell + 1)};
  Ball place = (position - low) / (high - low);
  // The position itself is in [0, 1], so the radius still holds.
  place.middle = std::clamp(place.middle, 0.0, 1.0);
  return place;
}

}  // namespace rhoray::render::exact
