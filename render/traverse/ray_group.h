#pragma once

#include <cstddef>
#include <cstdint>

#include "render/traverse/ray.h"

namespace rhoray::render::wide {

/// Up to 64 rays whose directions lie in one octant, with what a walk through a lattice needs of
/// them. Each number is in an array of its own; lanes from `count` to the next multiple of 16
/// repeat the last ray.
///
/// The time of a plane is (plane - plane_origin) * inverse, bit for bit as in PlaneTimesOf. On an
/// axis along which a ray passes no plane, the origin is moved to the middle of the ray's cell and
/// the inverse is huge: planes behind count as passed at once and those ahead are never passed.
struct alignas(64) RayGroup {
  static constexpr std::size_t size = 64;

  double origin[3][size], direction[3][size];
  double plane_origin[3][size], inverse[3][size];
  double t_in[size], t_out[size];  ///< the part inside the lattice
  std::uint32_t index[size];       ///< index in the batch
  std::uint64_t inside;            ///< rays that have such a part
  std::uint64_t grazing;           ///< rays for which rounding hides whether they meet the lattice
  std::size_t count;
  bool is_in_order;  ///< ray r of the group is ray r of the batch
  unsigned octant;   ///< bit a: the rays move down on axis a
  int major;         ///< the axis along which the rays together move most
};

/// A batch's rays as plain arrays, starting at the first of a chunk of at most 64.
struct RayArrays {
  const double* origin[3];
  const double* direction[3];
  const double* t_min;
  const double* t_max;
  const StartSide* start_side;  ///< null: all unknown
};

}  // namespace rhoray::render::wide
