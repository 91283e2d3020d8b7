#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "formats/base/checks.h"
#include "formats/base/vector.h"

namespace rhoray::render {

/// On which side of the isosurface a ray starts, where that is known and need not be read from the
/// field.
enum class StartSide : std::int8_t { outside = -1, unknown = 0, inside = 1 };

/// Largest distance from the surface, in cells, of the start of a ray that is said to start in a
/// crossing. In single precision crossings are found to 2^-20 of a cell.
inline constexpr double start_error_cells = 0x1p-17;

/// Points origin + t * direction with t_min <= t <= t_max, in the frame of the code that holds it.
/// The direction need not be of unit length: kernels work in the lattice's frame, where t stays the
/// distance in world units.
struct Ray {
  Vec3 origin;
  Vec3 direction;
  double t_min = 0;
  double t_max = std::numeric_limits<double>::infinity();
  /// Known for a ray that starts in a crossing, where rounding leaves the field's sign open. The
  /// ray's first crossing is then the first at which it leaves this side. It is neither the
  /// crossing that the ray starts in nor one beside it, where the start is known only up to
  /// rounding. The methods `direct` and `preview` take it into account.
  StartSide start_side = StartSide::unknown;

  Vec3 at(double t) const { return origin + t * direction; }
};

/// Planes at whole numbers: plane k of every axis lies at k.
struct WholePlanes {
  RHORAY_INLINE double position(int, std::int64_t plane) const { return static_cast<double>(plane); }

  /// A position in numbers of planes: its floor is the last plane at or below it.
  /// @param first, last  the range that matters: for positions beyond these planes, any number at
  ///                     or beyond them may be returned
  RHORAY_INLINE double in_planes(int, double position, std::int64_t, std::int64_t) const { return position; }
};

/// Planes at positions given by tables, each strictly rising. The tables must outlive this.
class TablePlanes {
 public:
  explicit TablePlanes(const std::array<std::vector<double>, 3>& planes)
      : tables_{planes[0].data(), planes[1].data(), planes[2].data()} {}

  RHORAY_INLINE double position(int axis, std::int64_t plane) const { return tables_[axis][plane]; }

  /// As for WholePlanes; `first` for a NaN.
  RHORAY_INLINE double in_planes(int axis, double position, std::int64_t first, std::int64_t last) const {
    std::int64_t below = first, beyond = last + 1;
    while (beyond - below > 1) {
      const std::int64_t middle = below + (beyond - below) / 2;
      if (tables_[axis][middle] <= position)
        below = middle;
      else
        beyond = middle;
    }
    return static_cast<double>(below);
  }

 private:
  const double* tables_[3];
};

/// The t at which a ray passes the planes of a lattice.
///
/// Every level of a hierarchy calls this one function with whole numbers of leaf cells, so all
/// levels agree bit for bit on when a plane is passed. Times rise with the order of planes along
/// the ray because rounding is monotone (nothing is accumulated from step to step).
template <class Planes>
class PlaneTimesOf {
 public:
  RHORAY_INLINE explicit PlaneTimesOf(const Ray& ray, const Planes& planes = {})
      : origin_(ray.origin), planes_(planes) {
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray.direction[axis];
      inverse_[axis] = 1 / d;
      // A component whose inverse overflows (below 6e-309) does not move, unless the whole
      // direction is as small.
      step_[axis] = !std::isfinite(inverse_[axis]) ? 0 : d > 0 ? 1 : -1;
    }
  }

  /// +1, -1, or 0 on an axis along which the ray never passes a plane.
  RHORAY_INLINE int step(int axis) const { return step_[axis]; }

  /// Only valid on an axis along which the ray moves.
  RHORAY_INLINE double at(int axis, std::int64_t plane) const {
    return (planes_.position(axis, plane) - origin_[axis]) * inverse_[axis];
  }

  RHORAY_INLINE const Planes& planes() const { return planes_; }

 private:
  Vec3 origin_;
  Vec3 inverse_;
  [[no_unique_address]] Planes planes_;
  int step_[3];
};

using PlaneTimes = PlaneTimesOf<WholePlanes>;

}  // namespace rhoray::render
