#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "render/cell/side.h"
#include "render/traverse/ray.h"

namespace rhoray::render {

/// A vertex seen along the ray: (x, y) is its position in the ray's picture plane, where the ray is
/// at (0, 0). t is where the ray reaches the vertex's coordinate on the dominant axis.
template <class Real>
struct SeenVertex {
  Real x, y;
  double t;
};

/// A ray's own frame, in which it runs along one axis: a shear that depends on the ray alone, so
/// that a vertex gets the same bits in every tetrahedron that shares it (Woop, Benthin and Wald,
/// JCGT 2013).
///
/// The shear is done in double and positions are rounded to Real last: the relative precision of a
/// position close to the ray is the same however far away the ray starts.
template <class Real>
class RayShearOf {
 public:
  using Seen = SeenVertex<Real>;

  /// The direction must not be zero.
  RHORAY_INLINE explicit RayShearOf(const Ray& ray) : origin_(ray.origin) {
    const Vec3& d = ray.direction;
    axis_z_ = std::abs(d.x) >= std::abs(d.y) ? (std::abs(d.x) >= std::abs(d.z) ? 0 : 2)
                                             : (std::abs(d.y) >= std::abs(d.z) ? 1 : 2);
    axis_x_ = (axis_z_ + 1) % 3;
    axis_y_ = (axis_z_ + 2) % 3;
    inverse_z_ = 1 / d[axis_z_];
    shear_x_ = without_underflow(d[axis_x_] * inverse_z_);
    shear_y_ = without_underflow(d[axis_y_] * inverse_z_);
  }

  RHORAY_INLINE Seen see(const std::array<double, 3>& vertex) const {
    const double z = from_origin(vertex, axis_z_);
    return {static_cast<Real>(from_origin(vertex, axis_x_) - shear_x_ * z),
            static_cast<Real>(from_origin(vertex, axis_y_) - shear_y_ * z), z * inverse_z_};
  }

  /// Error bounds for x, y and t of see(vertex).
  struct Errors {
    double x, y, t;
  };
  /// With u = 2^-53: the slope has a relative error of 2u (the inverse and the product; or an error
  /// of 1e-100), the difference z one of u, their product one more u. The difference along the axis
  /// has u, and the last subtraction u of the sum of both. That is at most 2u of the one and 5u of
  /// the other. Rounding to float adds 2^-24 of the position.
  RHORAY_INLINE Errors errors(const std::array<double, 3>& vertex, const Seen& seen) const {
    constexpr double u = 0x1p-53, least = 1e-300;
    constexpr bool rounds = std::numeric_limits<Real>::digits < 53;
    constexpr double last = rounds ? 0x1.01p-24 : 0, least_place = rounds ? std::numeric_limits<Real>::denorm_min() : 0;
    const double z = std::abs(from_origin(vertex, axis_z_));
    const auto at = [&](int axis, double slope, Real place) {
      return 2.1 * u * std::abs(from_origin(vertex, axis)) + (5.1 * u * std::abs(slope) + 1e-100) * z +
             last * std::abs(static_cast<double>(place)) + least_place + least;
    };
    return {at(axis_x_, shear_x_, seen.x), at(axis_y_, shear_y_, seen.y), 3.1 * u * std::abs(seen.t) + least};
  }

 private:
  /// A slope this small moves a vertex by no more than products with it would lose to underflow.
  RHORAY_INLINE static double without_underflow(double slope) { return std::abs(slope) < 1e-100 ? 0 : slope; }

  RHORAY_INLINE double from_origin(const std::array<double, 3>& vertex, int axis) const {
    return vertex[static_cast<std::size_t>(axis)] - origin_[axis];
  }

  Vec3 origin_;
  int axis_x_, axis_y_, axis_z_;
  double inverse_z_, shear_x_, shear_y_;
};
using RayShear = RayShearOf<double>;

/// A tetrahedron as a ray sees it. Vertices are in rising order of their ids, whatever the cell's
/// own order, so that two cells that share a face compute the same bits on it.
template <class Real>
struct SeenTetOf {
  std::array<SeenVertex<Real>, 4> vertex;
  std::array<double, 4> value;
};
using SeenTet = SeenTetOf<double>;

/// On which side of the ray the edge from a to b passes: true where a x b > 0 in the picture plane,
/// by the exact sign of x_a y_b - y_a x_b for the given numbers (for doubles short of underflow).
/// An edge through the ray is decided as if the ray stood at (e, e^2) for a vanishing e > 0. So
/// every tetrahedron is crossed through no face or through two.
template <class Real>
RHORAY_INLINE bool passes_left(const SeenVertex<Real>& a, const SeenVertex<Real>& b) {
  const Real p = a.x * b.y, q = a.y * b.x;
  // Rounding is monotone: it may make them equal but never exchanges them.
  if (p != q) return p > q;
  if constexpr (std::numeric_limits<Real>::digits < 53) {
    const double exact_p = static_cast<double>(a.x) * b.y, exact_q = static_cast<double>(a.y) * b.x;
    if (exact_p != exact_q) return exact_p > exact_q;
  } else {
    const Real p_rest = std::fma(a.x, b.y, -p), q_rest = std::fma(a.y, b.x, -q);
    if (p_rest != q_rest) return p_rest > q_rest;
  }
  if (a.y != b.y) return a.y > b.y;
  return b.x > a.x;
}

/// x_a y_b - y_a x_b|: twice the area of the triangle formed by the ray's position and the edge,
/// without cancellation.
template <class Real>
RHORAY_INLINE double edge_weight(const SeenVertex<Real>& a, const SeenVertex<Real>& b) {
  const double ax = a.x, ay = a.y, bx = b.x, by = b.y;
  const double p = ax * by, q = ay * bx;
  // The products are exact.
  if constexpr (std::numeric_limits<Real>::digits < 53) return std::abs(p - q);
  return std::abs((p - q) + (std::fma(ax, by, -p) - std::fma(ay, bx, -q)));
}

/// Where a ray passes through a face, and the field value there.
struct FaceCrossing {
  double t;
  double value;
};

/// The crossing of face (i, j, k), indices rising, that the ray is known to pass through:
/// barycentric weights from the edges, the same bits from both sides. A face seen edge-on, of no
/// area, gives the mean of its vertices.
/// @param offset  subtracted from the vertex values before they are averaged
template <class Real>
RHORAY_INLINE FaceCrossing cross_face(const SeenTetOf<Real>& tet, std::size_t i, std::size_t j, std::size_t k,
                                      double offset) {
  double wi = edge_weight(tet.vertex[j], tet.vertex[k]);
  double wj = edge_weight(tet.vertex[i], tet.vertex[k]);
  double wk = edge_weight(tet.vertex[i], tet.vertex[j]);
  double sum = wi + wj + wk;
  if (!(sum > 0)) wi = wj = wk = 1, sum = 3;
  return {(wi * tet.vertex[i].t + wj * tet.vertex[j].t + wk * tet.vertex[k].t) / sum,
          (wi * (tet.value[i] - offset) + wj * (tet.value[j] - offset) + wk * (tet.value[k] - offset)) / sum};
}

struct TetPassage {
  FaceCrossing in, out;  ///< in.t <= out.t
};

/// Where the ray enters and leaves a tetrahedron, or nothing. Neighbours agree on every face
/// between them: along a ray through a mesh no crossing is lost and none is found twice, whatever
/// the shape of the cells, including flat ones.
template <class Real>
RHORAY_INLINE std::optional<TetPassage> pass_through(const SeenTetOf<Real>& tet, double offset) {
  const auto& v = tet.vertex;
  const bool e01 = passes_left(v[0], v[1]), e02 = passes_left(v[0], v[2]), e03 = passes_left(v[0], v[3]);
  const bool e12 = passes_left(v[1], v[2]), e13 = passes_left(v[1], v[3]), e23 = passes_left(v[2], v[3]);
  struct Face {
    bool is_crossed;
    std::size_t i, j, k;
  };
  const std::array<Face, 4> faces{{{e12 == e23 && e12 != e13, 1, 2, 3},
                                   {e02 == e23 && e02 != e03, 0, 2, 3},
                                   {e01 == e13 && e01 != e03, 0, 1, 3},
                                   {e01 == e12 && e01 != e02, 0, 1, 2}}};
  std::array<FaceCrossing, 2> crossing{};
  std::size_t count = 0;
  for (const Face& face : faces)
    if (face.is_crossed && count < 2) crossing[count++] = cross_face(tet, face.i, face.j, face.k, offset);
  if (count < 2) return std::nullopt;
  if (crossing[1].t < crossing[0].t) std::swap(crossing[0], crossing[1]);
  return TetPassage{crossing[0], crossing[1]};
}

/// The passage cut to [t_min, t_max]; nothing when it lies outside.
RHORAY_INLINE std::optional<TetPassage> clip(TetPassage passage, double t_min, double t_max) {
  if (!(passage.out.t >= t_min && passage.in.t <= t_max))
    return std::nullopt;  // written so that a NaN also leaves here
  const auto value_at = [whole = passage](double t) {
    const double s = (t - whole.in.t) / (whole.out.t - whole.in.t);
    return (1 - s) * whole.in.value + s * whole.out.value;
  };
  if (passage.in.t < t_min) passage.in = {t_min, value_at(t_min)};
  if (passage.out.t > t_max) passage.out = {t_max, value_at(t_max)};
  return passage;
}

/// Where the field crosses the isovalue between entry and exit. This is a change of side, so there
/// is at most one, and no tolerance is needed.
/// @param passage  with the isovalue subtracted from its values
RHORAY_INLINE std::optional<double> first_crossing(const TetPassage& passage) {
  const auto& [in, out] = passage;
  if (is_inside(in.value) == is_inside(out.value)) return std::nullopt;
  const double t = in.t + (out.t - in.t) * (in.value / (in.value - out.value));
  return std::clamp(t, in.t, out.t);
}

/// The gradient of the linear field on a tetrahedron: sum of rho_i times the gradient of
/// barycentric coordinate i (paper, Appendix B). A cell without volume has none; it gets the normal
/// of its plane, or zero when it is a line.
RHORAY_INLINE Vec3 tet_gradient(const std::array<std::array<double, 3>, 4>& p, const std::array<double, 4>& value) {
  const auto edge = [&](std::size_t to) { return Vec3(p[to][0] - p[0][0], p[to][1] - p[0][1], p[to][2] - p[0][2]); };
  const Vec3 a = edge(1), b = edge(2), c = edge(3);
  const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  const double six_volumes = a.dot(bc);
  const Vec3 sum = (value[1] - value[0]) * bc + (value[2] - value[0]) * ca + (value[3] - value[0]) * ab;
  if (six_volumes != 0 && std::isfinite(1 / six_volumes)) return sum / six_volumes;
  const Vec3 opposite = (b - a).cross(c - a);
  Vec3 normal = ab;
  for (const Vec3& candidate : {bc, ca, opposite})
    if (candidate.length2() > normal.length2()) normal = candidate;
  return normal;
}

}  // namespace rhoray::render
