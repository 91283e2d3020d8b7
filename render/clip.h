#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::render {

/// The side of a plane to which its normal points, including the plane; world axes.
struct HalfSpace {
  Vec3 point{0, 0, 0};
  Vec3 normal{0, 0, 1};  ///< any length but 0
};

/// A clip region, world axes: the intersection of the box, which may be unbounded, and all half
/// spaces. The region is closed and convex.
///
/// Clipped layers are shown only inside the region. With `cuts_away` they are shown only outside
/// its interior. Rays end at the faces of the region. The t of a face is a double; its error is at
/// most the rounding of two products of three terms and of one quotient. A crossing is kept or
/// dropped by comparing its t with that t, as precisely as the layer's accuracy level determines
/// the crossing's t. A ray that begins at a face starts on the side of the isovalue that the field
/// has there, so no surface is drawn in a face. Shadow rays and occlusion rays are clipped in the
/// same way: what is clipped away casts no shadow.
struct Clip {
  static constexpr std::size_t most_planes = 6;

  std::optional<Box3> box{};
  std::vector<HalfSpace> planes{};
  bool cuts_away = false;

  bool keeps_all() const { return !box && planes.empty(); }
};

/// Returns the half spaces of a region. The finite faces of its box come first: x low, x high, y
/// low, ...
std::vector<HalfSpace> half_spaces_of(const Clip& clip);

/// Returns a box around the part of a box that remains after clipping; empty when nothing remains.
/// Rounding may make the result too large.
Box3 what_is_left(const Clip& clip, const Box3& box);

/// True when the region removes nothing of a box, to rounding.
bool leaves_whole(const Clip& clip, const Box3& box);

/// Returns a box around the part of a plane inside a box; empty when the plane misses the box.
Box3 part_of_plane(const HalfSpace& plane, const Box3& box);

}  // namespace rhoray::render
