#include "preprocess/mesh/boundary_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "formats/base/floating_point.h"
#include "formats/base/parallel.h"
#include "formats/base/vector.h"

namespace rhoray::preprocess {
namespace {

struct Triangle {
  Vec3 a, b, c;
};

/// Squared distance by the region of the triangle that is nearest: a corner, an edge or the inside
/// (Ericson, Real-Time Collision Detection, 5.1.5). A triangle without area is treated as its
/// edges.
double squared_distance(const Vec3& p, const Triangle& t) {
  const Vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.length2();
  const Vec3 bp = p - t.b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.length2();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).length2();
  const Vec3 cp = p - t.c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.length2();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).length2();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t.c - t.b)).length2();
  const double sum = va + vb + vc;
  return (ap - vb / sum * ab - vc / sum * ac).length2();
}

/// A binary tree over triangles. Each node is halved across the longest side of the box of its
/// triangles' centres. Nodes are stored in preorder: the first child follows its parent.
class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
    nodes_.reserve(triangles_.size());
    build(0, triangles_.size());
  }

  double squared_distance_to(const Vec3& p) const {
    if (!std::isfinite(p.x + p.y + p.z)) return std::numeric_limits<double>::quiet_NaN();
    double nearest = std::numeric_limits<double>::infinity();
    search(0, p, nearest);
    return nearest;
  }

 private:
  static constexpr std::size_t most_in_leaf = 4;

  struct Node {
    Box3 box;
    std::size_t begin = 0, end = 0;  ///< triangles of a leaf
    std::size_t second = 0;          ///< the other child; 0 for a leaf
  };

  static double squared_distance_to_box(const Vec3& p, const Box3& box) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = std::max({box.min[axis] - p[axis], 0.0, p[axis] - box.max[axis]});
      sum += d * d;
    }
    return sum;
  }

  std::size_t build(std::size_t begin, std::size_t end) {
    const std::size_t node = nodes_.size();
    nodes_.push_back({.box = {}, .begin = begin, .end = end});
    Box3 centres;
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle& t = triangles_[i];
      for (const Vec3& corner : {t.a, t.b, t.c}) nodes_[node].box.extendBy(corner);
      centres.extendBy(t.a + t.b + t.c);
    }
    if (end - begin <= most_in_leaf) return node;
    const int axis = static_cast<int>(centres.majorAxis());
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const Triangle& s, const Triangle& t) {
      return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
    });
    build(begin, middle);
    const std::size_t second = build(middle, end);
    nodes_[node].second = second;
    return node;
  }

  /// Visits the nearer child first, so that the farther one is rarely entered.
  void search(std::size_t index, const Vec3& p, double& nearest) const {
    const Node& node = nodes_[index];
    if (node.second == 0) {
      for (std::size_t i = node.begin; i < node.end; ++i)
        nearest = std::min(nearest, squared_distance(p, triangles_[i]));
      return;
    }
    std::size_t near = index + 1, far = node.second;
    double to_near = squared_distance_to_box(p, nodes_[near].box), to_far = squared_distance_to_box(p, nodes_[far].box);
    if (to_far < to_near) {
      std::swap(near, far);
      std::swap(to_near, to_far);
    }
    if (to_near < nearest) search(near, p, nearest);
    if (to_far < nearest) search(far, p, nearest);
  }

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

/// The power of two next above all coordinates of the triangles' corners; 0 when all are 0.
int exponent_of(std::span<const std::array<std::uint64_t, 3>> triangles,
                std::span<const std::array<double, 3>> points) {
  double largest = 0;
  for (const auto& t : triangles)
    for (const std::uint64_t corner : t)
      for (const double x : points[corner]) largest = std::max(largest, std::abs(x));
  int exponent = 0;
  std::frexp(largest, &exponent);
  return exponent;
}

}  // namespace

Array<double> distances_to(std::span<const std::array<std::uint64_t, 3>> triangles,
                           std::span<const std::array<double, 3>> points) {
  const DefaultFloatingPoint default_floating_point;
  // Products of four lengths must neither overflow nor underflow. A power of two changes no digit.
  const int exponent = exponent_of(triangles, points);
  const auto place = [&](std::uint64_t point) {
    const auto& p = points[point];
    return Vec3(std::ldexp(p[0], -exponent), std::ldexp(p[1], -exponent), std::ldexp(p[2], -exponent));
  };
  Array<double> distances(points.size(), -1);
  std::vector<Triangle> placed;
  placed.reserve(triangles.size());
  for (const auto& t : triangles) {
    placed.push_back({place(t[0]), place(t[1]), place(t[2])});
    for (const std::uint64_t corner : t) distances[corner] = 0;
  }
  const TriangleTree tree(std::move(placed));
  for_each_range(points.size(), 1000, 0, [&](std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t p = first; p < last; ++p)
      if (distances[p] != 0) distances[p] = std::ldexp(std::sqrt(tree.squared_distance_to(place(p))), exponent);
  });
  return distances;
}

}  // namespace rhoray::preprocess
