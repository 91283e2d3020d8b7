#include "preprocess/mesh/inspect/cut_polygon.h"

#include <cmath>

namespace rhoray::preprocess {
namespace {

using Place = std::array<double, 2>;

/// Twice the area of a triangle in the plane, above 0 for counter-clockwise winding.
double turn(const Place& a, const Place& b, const Place& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Projects the corners to a plane in which the polygon runs counter-clockwise.
std::vector<Place> project(std::span<const Vec3> corners) {
  Vec3 normal(0, 0, 0);
  for (std::size_t i = 0; i + 1 < corners.size(); ++i)
    normal += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(normal[a]) > std::abs(normal[axis])) axis = a;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<Place> places;
  places.reserve(corners.size());
  for (const Vec3& corner : corners)
    places.push_back(normal[axis] < 0 ? Place{corner[v], corner[u]} : Place{corner[u], corner[v]});
  return places;
}

/// True when the corner at `at` of the remaining ones can be cut off: it is convex, and no other
/// corner lies in its triangle.
bool is_ear(const std::vector<Place>& places, const std::vector<std::size_t>& left, std::size_t at) {
  const std::size_t before = left[(at + left.size() - 1) % left.size()], after = left[(at + 1) % left.size()];
  const Place &a = places[before], &b = places[left[at]], &c = places[after];
  if (!(turn(a, b, c) > 0)) return false;
  for (const std::size_t other : left) {
    const Place& p = places[other];
    if (p == a || p == b || p == c) continue;
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<std::size_t, 3>> cut_polygon(std::span<const Vec3> corners) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < corners.size(); ++i) left.push_back(i);
  std::vector<std::array<std::size_t, 3>> triangles;
  const std::vector<Place> places = left.size() > 3 ? project(corners) : std::vector<Place>{};
  while (left.size() > 3) {
    std::size_t ear = 1;  // of a polygon that is not simple, or flat, any corner
    for (std::size_t at = 0; at < left.size(); ++at)
      if (is_ear(places, left, (at + 1) % left.size())) {
        ear = (at + 1) % left.size();
        break;
      }
    triangles.push_back({left[(ear + left.size() - 1) % left.size()], left[ear], left[(ear + 1) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace rhoray::preprocess
