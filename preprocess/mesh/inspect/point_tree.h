#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::preprocess::inspect {

/// A k-d tree of numbered points for box queries: points are halved across x, y and z in turn
/// (Bentley, CACM 18, 1975).
class PointTree {
 public:
  struct Point {
    Vec3 place;
    std::uint64_t number;
  };

  explicit PointTree(std::vector<Point> points) : points_(std::move(points)) { part(0, points_.size(), 0); }

  /// Calls visit(number) for every point in the box, boundary included.
  template <class Visit>
  void for_each_in(const Box3& box, Visit&& visit) const {
    walk(box, 0, points_.size(), 0, visit);
  }

 private:
  void part(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [axis](const Point& a, const Point& b) { return a.place[axis] < b.place[axis]; });
    part(begin, middle, (axis + 1) % 3);
    part(middle + 1, end, (axis + 1) % 3);
  }

  template <class Visit>
  void walk(const Box3& box, std::size_t begin, std::size_t end, int axis, Visit& visit) const {
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const Point& point = points_[middle];
    if (box.min[axis] <= point.place[axis]) walk(box, begin, middle, (axis + 1) % 3, visit);
    if (box.intersects(point.place)) visit(point.number);
    if (point.place[axis] <= box.max[axis]) walk(box, middle + 1, end, (axis + 1) % 3, visit);
  }

  std::vector<Point> points_;
};

}  // namespace rhoray::preprocess::inspect
