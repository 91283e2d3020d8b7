#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::render {

/// The side of a plane to which its normal points, the plane included; world axes.
struct HalfSpace {
  Vec3 point{0, 0, 0};
  Vec3 normal{0, 0, 1};  ///< of any length but 0
};

/// A part of space, world axes: what lies in the box, which may be unbounded, and in all of the half spaces. It is
/// closed, and convex.
///
/// Of layers that are clipped only what lies in the region is shown, or, where it is cut away, only what does not lie
/// in its inside. Rays end at its faces, at a t in double precision that is off by no more than the rounding of two
/// products of three terms and of a quotient: a crossing of smaller or larger t is in or out by that, as far as the
/// layer's level tells its t. A ray that begins at a face begins on the side that the field has there, so that no
/// surface is drawn in a face. Rays towards lights and into surroundings end likewise: what is clipped away holds no
/// light back.
struct Clip {
  static constexpr std::size_t most_planes = 6;

  std::optional<Box3> box{};
  std::vector<HalfSpace> planes{};
  bool cuts_away = false;

  bool keeps_all() const { return !box && planes.empty(); }
};

/// The half spaces of a region, a box's finite faces first: x low, x high, y low, ...
std::vector<HalfSpace> half_spaces_of(const Clip& clip);

/// Around what is left of a box; empty where nothing is. To rounding, of which it may be too large.
Box3 what_is_left(const Clip& clip, const Box3& box);

/// True where the region takes nothing away of a box, to rounding.
bool leaves_whole(const Clip& clip, const Box3& box);

/// Around the part of a plane in a box; empty where it passes the box by.
Box3 part_of_plane(const HalfSpace& plane, const Box3& box);

}  // namespace rhoray::render
