#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "formats/leaf_lists.h"

namespace rhoray::preprocess {

/// Finds the leaf cells that a tetrahedron touches: all of them, and none that is farther from it
/// than 1e-6 of a leaf cell's edge. Leaf cells are enlarged by that margin here, so that rounding
/// loses none.
///
/// A box and a tetrahedron are disjoint exactly when one of 25 directions separates them: 3 box
/// axes, 4 face normals, 18 products of box axes with edges. Along each direction, the leaf cells
/// of one row (fixed j, k) that are not separated are consecutive. A row therefore needs one
/// interval per direction instead of one test per leaf cell:
///
///   k fixed:    products with x  ->  an interval of j     products with y  ->  an interval of i
///   j fixed:    products with z  ->  an interval of i
///   j, k fixed: face normals     ->  an interval of i
///
/// A direction is only a witness: the projections on it are compared as computed, so the
/// direction's own rounding does no harm.
class TouchedLeaves {
 public:
  explicit TouchedLeaves(const formats::LeafLattice& lattice) : lattice_(lattice) {}

  /// Calls visit(i_first, i_last, j, k) for every row that has such leaf cells, ascending in k,
  /// then j.
  /// @param points  in the lattice's frame, inside the lattice
  template <class Visit>
  void for_each_row(const std::array<std::array<double, 3>, 4>& points, Visit&& visit) {
    if (!place(points)) return visit_all(visit);
    find_directions();
    for (std::int64_t j = 0; j < size_.y; ++j)
      i_of_j_[static_cast<std::size_t>(j)] = meet(across_z_, center(j), whole(size_.x));
    for (std::int64_t k = 0; k < size_.z; ++k) {
      const Span of_j = meet(across_x_, center(k), whole(size_.y));
      const Span of_i = meet(across_y_, center(k), whole(size_.x));
      const std::int64_t j_last = last(of_j);
      for (std::int64_t j = first(of_j); j <= j_last; ++j) {
        Span row{std::max(of_i.lo, i_of_j_[static_cast<std::size_t>(j)].lo),
                 std::min(of_i.hi, i_of_j_[static_cast<std::size_t>(j)].hi)};
        for (const FaceNormal& face : faces_) row = face.in_x.meet(face.y * center(j) + face.z * center(k), row);
        if (first(row) <= last(row)) visit(base_.x + first(row), base_.x + last(row), base_.y + j, base_.z + k);
      }
    }
  }

 private:
  /// in leaf cells; rounding reaches 1e-9 at 2^20 leaf cells on an axis
  static constexpr double margin = 1e-6;

  /// A range of coordinates from lo to hi. `first` and `last` are the leaf cells whose centres lie
  /// in it; none when first > last.
  struct Span {
    double lo, hi;
  };
  static double center(std::int64_t index) { return static_cast<double>(index) + 0.5; }
  static Span whole(std::int64_t size) { return {0.5, static_cast<double>(size) - 0.5}; }
  static std::int64_t first(const Span& span) {
    if (!(span.lo <= span.hi)) return 1;
    const auto below = static_cast<std::int64_t>(span.lo - 0.5);  // spans start at 0.5 or above
    return below + (center(below) < span.lo);
  }
  static std::int64_t last(const Span& span) {
    if (!(span.lo <= span.hi)) return 0;
    return static_cast<std::int64_t>(span.hi - 0.5);
  }

  /// Along a direction with component `slope` on the axis in question: the centres c with slope * c
  /// + rest in [lo, hi].
  struct Constraint {
    double slope = 0, inverse = 0;
    double lo = 0, hi = 0;

    Span meet(double rest, Span span) const {
      if (inverse == 0) {  // the direction does not constrain this axis
        if (rest < lo || rest > hi) span.hi = -std::numeric_limits<double>::infinity();
        return span;
      }
      const double a = (lo - rest) * inverse, b = (hi - rest) * inverse;
      return {std::max(span.lo, std::min(a, b)), std::min(span.hi, std::max(a, b))};
    }
  };
  struct EdgeProduct {  ///< a box axis times an edge: has only two nonzero components
    Constraint on_first;
    double second;
  };
  struct FaceNormal {
    Constraint in_x;
    double y, z;
  };

  static Span meet(const std::array<EdgeProduct, 6>& products, double center_second, Span span) {
    for (const EdgeProduct& product : products) span = product.on_first.meet(product.second * center_second, span);
    return span;
  }

  /// Moves the points to units of leaf cells, counted from the first leaf cell of their box.
  /// Returns false when that box is one row of leaf cells, all of which are touched.
  bool place(const std::array<std::array<double, 3>, 4>& points) {
    int long_axes = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      double lo = std::numeric_limits<double>::infinity(), hi = -lo;
      for (std::size_t v = 0; v < 4; ++v) {
        q_[v][a] = (points[v][a] - lattice_.low[axis]) / lattice_.leaf_size[axis];
        lo = std::min(lo, q_[v][a]);
        hi = std::max(hi, q_[v][a]);
      }
      const std::int64_t largest = lattice_.macro.leaf_count[axis] - 1;
      const auto leaf_of = [&](double x) { return x <= 0 ? 0 : std::min(static_cast<std::int64_t>(x), largest); };
      base_[axis] = leaf_of(lo - margin);
      size_[axis] = leaf_of(hi + margin) - base_[axis] + 1;
      long_axes += size_[axis] > 1;
      for (auto& point : q_) point[a] -= static_cast<double>(base_[axis]);
    }
    if (static_cast<std::size_t>(size_.y) > i_of_j_.size()) i_of_j_.resize(static_cast<std::size_t>(size_.y));
    return long_axes > 1;
  }

  template <class Visit>
  void visit_all(Visit&& visit) const {
    for (std::int64_t k = 0; k < size_.z; ++k)
      for (std::int64_t j = 0; j < size_.y; ++j) visit(base_.x, base_.x + size_.x - 1, base_.y + j, base_.z + k);
  }

  /// @param projected  the four points along the direction
  /// @param magnitude  the sum of the direction's absolute components: a leaf cell's extent along
  ///                   it
  static Constraint constraint(double slope, const std::array<double, 4>& projected, double magnitude) {
    const double reach = (0.5 + margin) * magnitude;
    const double lo = std::min(std::min(projected[0], projected[1]), std::min(projected[2], projected[3])) - reach;
    const double hi = std::max(std::max(projected[0], projected[1]), std::max(projected[2], projected[3])) + reach;
    // below, 1 / slope may overflow: the direction then excludes nothing
    constexpr double smallest = 1e-290;
    if (slope == 0) return {.slope = 0, .inverse = 0, .lo = lo, .hi = hi};
    if (std::abs(slope) < smallest)
      return {.slope = 0,
              .inverse = 0,
              .lo = -std::numeric_limits<double>::infinity(),
              .hi = std::numeric_limits<double>::infinity()};
    return {.slope = slope, .inverse = 1 / slope, .lo = lo, .hi = hi};
  }

  /// The edge's normal in the plane of two axes.
  EdgeProduct edge_product(const std::array<double, 3>& edge, std::size_t axis, std::size_t second) const {
    const double on_axis = edge[second], on_second = -edge[axis];
    std::array<double, 4> projected;
    for (std::size_t v = 0; v < 4; ++v) projected[v] = on_axis * q_[v][axis] + on_second * q_[v][second];
    return {constraint(on_axis, projected, std::abs(on_axis) + std::abs(on_second)), on_second};
  }

  FaceNormal face_normal(const std::array<double, 3>& a, const std::array<double, 3>& b) const {
    const std::array<double, 3> n{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    std::array<double, 4> projected;
    for (std::size_t v = 0; v < 4; ++v) projected[v] = n[0] * q_[v][0] + n[1] * q_[v][1] + n[2] * q_[v][2];
    return {constraint(n[0], projected, std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2])), n[1], n[2]};
  }

  void find_directions() {
    constexpr std::array<std::array<std::size_t, 2>, 6> ends{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
    std::array<std::array<double, 3>, 6> edges;
    for (std::size_t e = 0; e < 6; ++e) {
      for (std::size_t axis = 0; axis < 3; ++axis) edges[e][axis] = q_[ends[e][1]][axis] - q_[ends[e][0]][axis];
      across_x_[e] = edge_product(edges[e], 1, 2);
      across_y_[e] = edge_product(edges[e], 0, 2);
      across_z_[e] = edge_product(edges[e], 0, 1);
    }
    faces_ = {face_normal(edges[0], edges[1]), face_normal(edges[0], edges[2]), face_normal(edges[1], edges[2]),
              face_normal(edges[3], edges[4])};
  }

  const formats::LeafLattice& lattice_;
  std::array<std::array<double, 3>, 4> q_;
  Index3 base_, size_;  ///< first leaf cell of the tetrahedron's box, and its size in leaf cells
  std::array<EdgeProduct, 6> across_x_, across_y_, across_z_;
  std::array<FaceNormal, 4> faces_;
  std::vector<Span> i_of_j_;
};

}  // namespace rhoray::preprocess
