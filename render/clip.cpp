#include "render/clip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/base/floating_point.h"

namespace rhoray::render {

namespace {

/// Upper bound of the error of a corner computed from three planes, for a box of this size.
double slack_of(const Box3& box) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, std::abs(box.min[axis]), std::abs(box.max[axis])});
  return 0x1p-36 * largest;
}

std::array<Vec3, 8> corners_of(const Box3& box) {
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i] = {(i & 1) != 0 ? box.max.x : box.min.x, (i & 2) != 0 ? box.max.y : box.min.y,
                  (i & 4) != 0 ? box.max.z : box.min.z};
  return corners;
}

/// How far a point is inside a half space; negative outside.
double depth_in(const HalfSpace& half, const Vec3& place) {
  return half.normal.normalized().dot(place - half.point);
}

/// Adds the finite faces of a box.
void add_faces(const Box3& box, std::vector<HalfSpace>& halves) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const double place = sign > 0 ? box.min[axis] : box.max[axis];
      if (!std::isfinite(place)) continue;
      HalfSpace half{.point = {0, 0, 0}, .normal = {0, 0, 0}};
      half.point[axis] = place;
      half.normal[axis] = sign;
      halves.push_back(half);
    }
}

/// Returns the intersection of three planes; not finite when they do not meet in a point.
Vec3 meeting_place(const HalfSpace& a, const HalfSpace& b, const HalfSpace& c, const Vec3& anchor) {
  const Vec3 na = a.normal.normalized(), nb = b.normal.normalized(), nc = c.normal.normalized();
  const double det = na.dot(nb.cross(nc));
  constexpr double nearly_parallel = 1e-9;
  if (!(std::abs(det) > nearly_parallel)) return Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  const double pa = na.dot(a.point - anchor), pb = nb.dot(b.point - anchor), pc = nc.dot(c.point - anchor);
  return anchor + (pa * nb.cross(nc) + pb * nc.cross(na) + pc * na.cross(nb)) / det;
}

/// Returns a box around the corners of the intersection of all half spaces; with a plane, around
/// those of its part of the intersection.
Box3 box_around_corners(const std::vector<HalfSpace>& halves, const HalfSpace* plane, double slack,
                        const Vec3& anchor) {
  Box3 around;
  const auto add = [&](const Vec3& corner) {
    if (!std::isfinite(corner.x)) return;
    for (const HalfSpace& half : halves)
      if (!(depth_in(half, corner) >= -slack)) return;
    around.extendBy(corner);
  };
  for (std::size_t i = 0; i < halves.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (plane != nullptr) add(meeting_place(halves[i], halves[j], *plane, anchor));
      for (std::size_t k = 0; plane == nullptr && k < j; ++k)
        add(meeting_place(halves[i], halves[j], halves[k], anchor));
    }
  return around;
}

bool lies_inside(const std::vector<HalfSpace>& halves, const Box3& box, double slack) {
  const auto corners = corners_of(box);
  return std::all_of(halves.begin(), halves.end(), [&](const HalfSpace& half) {
    return std::all_of(corners.begin(), corners.end(),
                       [&](const Vec3& corner) { return depth_in(half, corner) >= -slack; });
  });
}

}  // namespace

std::vector<HalfSpace> half_spaces_of(const Clip& clip) {
  const DefaultFloatingPoint default_floating_point;
  std::vector<HalfSpace> halves;
  if (clip.box) add_faces(*clip.box, halves);
  halves.insert(halves.end(), clip.planes.begin(), clip.planes.end());
  return halves;
}

Box3 what_is_left(const Clip& clip, const Box3& box) {
  const DefaultFloatingPoint default_floating_point;
  if (box.isEmpty()) return box;
  const double slack = slack_of(box);
  std::vector<HalfSpace> halves = half_spaces_of(clip);
  if (clip.cuts_away) return lies_inside(halves, box, -slack) ? Box3() : box;
  add_faces(box, halves);
  const Box3 left = box_around_corners(halves, nullptr, slack, box.center());
  return left.isEmpty() ? left
                        : Box3(Vec3(std::max(left.min.x, box.min.x), std::max(left.min.y, box.min.y),
                                    std::max(left.min.z, box.min.z)),
                               Vec3(std::min(left.max.x, box.max.x), std::min(left.max.y, box.max.y),
                                    std::min(left.max.z, box.max.z)));
}

bool leaves_whole(const Clip& clip, const Box3& box) {
  const DefaultFloatingPoint default_floating_point;
  if (clip.cuts_away) {
    Clip kept = clip;
    kept.cuts_away = false;
    return what_is_left(kept, box).isEmpty();
  }
  return lies_inside(half_spaces_of(clip), box, 0);
}

Box3 part_of_plane(const HalfSpace& plane, const Box3& box) {
  const DefaultFloatingPoint default_floating_point;
  if (box.isEmpty()) return box;
  std::vector<HalfSpace> halves;
  add_faces(box, halves);
  return box_around_corners(halves, &plane, slack_of(box), box.center());
}

}  // namespace rhoray::render
