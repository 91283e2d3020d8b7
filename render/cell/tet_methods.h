#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/cell/certified_crossing.h"
#include "render/cell/tet_crossing.h"

namespace rhoray::render {

/// How the crossing of a ray with the isosurface in a tetrahedron is found.
///
///   paper  Appendix B: the ray meets the isoplane where no barycentric coordinate is negative.
///          Where a ray crosses the surface in a shared face or edge, all cells that share it may
///          refuse the crossing
///   slack  the same, with coordinates down to -slack: close to a shared face both neighbours may
///          answer
///   edges  the field where the ray enters and leaves, by the sides on which the edges pass
///          (tet_crossing.h): along a ray through a mesh no crossing is lost or found twice
enum class TetMethod { paper, slack, edges };

using TetPoints = std::array<std::array<double, 3>, 4>;
using TetValues = std::array<double, 4>;

/// A slack that compensates for the rounding of Appendix B in double precision in tetrahedra that
/// are not slivers.
inline constexpr double default_tet_slack = 1e-12;

/// A ray and its shear for projecting vertices; built once per ray.
template <class Real>
struct TetRay {
  Ray ray;
  RayShearOf<Real> shear;

  RHORAY_INLINE explicit TetRay(const Ray& from) : ray(from), shear(from) {}
};

/// The tetrahedron as the ray sees it. Nothing when all of it lies on one side of the ray in x or
/// in y: the ray then passes through no face. This holds for most tetrahedra that are tested.
template <class Real>
RHORAY_INLINE std::optional<SeenTetOf<Real>> see_near(const RayShearOf<Real>& shear, const TetPoints& points,
                                                      const TetValues& values) {
  const SeenTetOf<Real> tet{{shear.see(points[0]), shear.see(points[1]), shear.see(points[2]), shear.see(points[3])},
                            values};
  const auto& v = tet.vertex;
  const auto [left, right] = std::minmax({v[0].x, v[1].x, v[2].x, v[3].x});
  const auto [below, above] = std::minmax({v[0].y, v[1].y, v[2].y, v[3].y});
  if (left > 0 || right < 0 || below > 0 || above < 0) return std::nullopt;
  return tet;
}

/// Appendix B of the paper in numbers of type Real: t where the ray meets the isoplane between
/// t_min and t_max, if all barycentric coordinates there are at least -slack times their sum.
/// Nothing where the field is constant along the ray. The coordinate of vertex i is the plane
/// equation n_i . (p - q) / n_i . (p_i - q) of the opposite face, with q in that face.
template <class Real>
RHORAY_INLINE std::optional<double> isoplane_crossing(const Ray& ray, const TetPoints& points, const TetValues& values,
                                                      double isovalue, double slack) {
  using Point = Imath::Vec3<Real>;
  const auto point = [&](std::size_t i) {
    return Point(static_cast<Real>(points[i][0]), static_cast<Real>(points[i][1]), static_cast<Real>(points[i][2]));
  };
  const Point a(ray.origin), b(ray.direction);
  std::array<Point, 4> normal;
  Real rho_a = 0, rho_b = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point q = point((i + 1) % 4);
    const Point n = (point((i + 2) % 4) - q).cross(point((i + 3) % 4) - q);
    normal[i] = n / n.dot(point(i) - q);
    rho_a += static_cast<Real>(values[i]) * normal[i].dot(a - q);
    rho_b += static_cast<Real>(values[i]) * normal[i].dot(b);
  }
  const Real t = (static_cast<Real>(isovalue) - rho_a) / rho_b;
  // Also for a NaN.
  if (!(t >= static_cast<Real>(ray.t_min) && t <= static_cast<Real>(ray.t_max))) return std::nullopt;
  const Point p = a + t * b;
  std::array<Real, 4> alpha;
  for (std::size_t i = 0; i < 4; ++i) alpha[i] = normal[i].dot(p - point((i + 1) % 4));
  const Real least = -static_cast<Real>(slack) * (alpha[0] + alpha[1] + alpha[2] + alpha[3]);
  for (const Real coordinate : alpha)
    if (!(coordinate >= least)) return std::nullopt;
  return static_cast<double>(t);
}

/// t of the crossing between t_min and t_max, or nothing.
/// @param points, values  in rising order of the vertices' ids, so that neighbours agree
/// @param slack           only for TetMethod::slack
template <class Real>
RHORAY_INLINE std::optional<double> find_crossing(TetMethod method, const TetRay<Real>& ray, const TetPoints& points,
                                                  const TetValues& values, double isovalue,
                                                  double slack = default_tet_slack) {
  if (method != TetMethod::edges)
    return isoplane_crossing<Real>(ray.ray, points, values, isovalue, method == TetMethod::slack ? slack : 0);
  const std::optional<SeenTetOf<Real>> seen = see_near(ray.shear, points, values);
  if (!seen) return std::nullopt;
  std::optional<TetPassage> passage = pass_through(*seen, isovalue);
  if (passage) passage = clip(*passage, ray.ray.t_min, ray.ray.t_max);
  if (!passage) return std::nullopt;
  return first_crossing(*passage);
}

/// The same, by TetMethod::edges, for a ray that starts in a crossing on a known side: a crossing
/// at which it leaves that side. Of the neighbours that the ray passes within rounding of its
/// start, only those count in which it leaves this side.
template <class Real>
RHORAY_INLINE std::optional<double> find_exit_crossing(const TetRay<Real>& ray, const TetPoints& points,
                                                       const TetValues& values, double isovalue, bool from_inside) {
  const std::optional<SeenTetOf<Real>> seen = see_near(ray.shear, points, values);
  if (!seen) return std::nullopt;
  const std::optional<TetPassage> passage = pass_through(*seen, isovalue);
  if (!passage || is_inside(passage->in.value) != from_inside) return std::nullopt;
  const std::optional<double> t = first_crossing(*passage);
  if (!t || !(*t >= ray.ray.t_min && *t <= ray.ray.t_max)) return std::nullopt;
  return t;
}

struct CertifiedTetCrossing {
  Decision decision = Decision::unknown;
  double t = 0;
  double t_error = 0;  ///< when it crosses: the exact crossing lies within t_error of t
};

namespace certified_tet {

/// x_a y_b - y_a x_b with a bound on its distance from the value for the exact positions.
struct Edge {
  double value, error;
  RHORAY_INLINE bool is_positive() const { return value > error; }
  RHORAY_INLINE bool is_negative() const { return value < -error; }
};

struct Vertex {
  double x, y, t;
  double x_error, y_error, t_error;
};

/// Errors of the positions enter linearly, and their products once more. Two products and a
/// difference are rounded.
RHORAY_INLINE Edge edge(const Vertex& a, const Vertex& b) {
  const double p = a.x * b.y, q = a.y * b.x;
  const double value = (p - q) + (std::fma(a.x, b.y, -p) - std::fma(a.y, b.x, -q));
  const double error = a.x_error * (std::abs(b.y) + b.y_error) + std::abs(a.x) * b.y_error +
                       a.y_error * (std::abs(b.x) + b.x_error) + std::abs(a.y) * b.x_error +
                       0x1p-52 * (std::abs(p) + std::abs(q));
  return {value, error * (1 + 0x1p-40) + 1e-300};
}

enum class Passes { not_at_all, inside, unknown };

/// Whether the ray passes through a face, from its edges in one sense of rotation: inside when all
/// turn the same way, not at all (not even on the rim) when two turn different ways.
RHORAY_INLINE Passes passes(const std::array<Edge, 3>& round) {
  int positive = 0, negative = 0;
  for (const Edge& e : round) positive += e.is_positive(), negative += e.is_negative();
  if (positive > 0 && negative > 0) return Passes::not_at_all;
  if (positive == 3 || negative == 3) return Passes::inside;
  return Passes::unknown;
}

/// The mean of three numbers with weights w, each off by at most d. The error is the sum of: sum d
/// |f - mean| / (sum w - sum d), the error of the numbers, and the rounding of ten operations.
struct Mean {
  double value, error;
};
RHORAY_INLINE Mean mean(const std::array<Edge, 3>& weights, const std::array<double, 3>& f, double f_error) {
  double sum = 0, doubt = 0, weighted = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double w = std::abs(weights[i].value);
    sum += w, doubt += weights[i].error, weighted += w * f[i];
  }
  const double least = std::min({f[0], f[1], f[2]}), most = std::max({f[0], f[1], f[2]});
  const double from_weights = doubt < 0.5 * sum ? (most - least) * (doubt / (sum - doubt)) : most - least;
  const double from_rounding = 0x1p-49 * std::max(std::abs(least), std::abs(most));
  return {sum > 0 ? weighted / sum : f[0], (1 + 0x1p-40) * (from_weights + f_error + from_rounding)};
}

/// Where the ray passes through a face, if it does.
struct Face {
  Mean t, value;
  std::optional<bool> is_inside;  ///< the side of the isosurface there, if certain
};

/// The exact weights have one sign wherever the ray meets the face, and are not zero when it meets
/// the inside. So if all values lie on one side, the side of their mean is certain.
/// @param f  values minus isovalue: rounded, but of the exact sign
RHORAY_INLINE Face cross(const std::array<Vertex, 4>& v, const std::array<double, 4>& f,
                         const std::array<std::size_t, 3>& corner, const std::array<Edge, 3>& weights, Passes how) {
  const auto& [i, j, k] = corner;
  Face face{mean(weights, {v[i].t, v[j].t, v[k].t}, std::max({v[i].t_error, v[j].t_error, v[k].t_error})),
            mean(weights, {f[i], f[j], f[k]}, 0), std::nullopt};
  const double least = std::min({f[i], f[j], f[k]}), most = std::max({f[i], f[j], f[k]});
  if (least >= 0)
    face.is_inside = true;
  else if (most < 0 || (most == 0 && how == Passes::inside))
    face.is_inside = false;
  else if (std::abs(face.value.value) > face.value.error)
    face.is_inside = face.value.value > 0;
  return face;
}

/// Where a linear field is zero that has value a at one end and b at the other, on different sides.
RHORAY_INLINE Mean crossing_between(const Face& a, const Face& b) {
  const auto least = [](const Mean& m) { return std::max(std::abs(m.value) - m.error, 0.0); };
  const auto most = [](const Mean& m) { return std::abs(m.value) + m.error; };
  const auto share = [](double of, double rest) { return of + rest > 0 ? of / (of + rest) : 0; };
  const double s_least = share(least(a.value), most(b.value)), s_most = 1 - share(least(b.value), most(a.value));
  const double s = 0.5 * (s_least + s_most), length = std::abs(b.t.value - a.t.value);
  const double from_rounding = 0x1p-50 * std::max(std::abs(a.t.value), std::abs(b.t.value));
  return {(1 - s) * a.t.value + s * b.t.value,
          (1 + 0x1p-40) * (0.5 * (s_most - s_least) * length + std::max(a.t.error, b.t.error) + from_rounding)};
}

/// The smallest enclosure of both.
RHORAY_INLINE Mean hull(const Mean& a, const Mean& b) {
  const double lo = std::min(a.value - a.error, b.value - b.error), hi = std::max(a.value + a.error, b.value + b.error);
  const double rounding = 0x1p-50 * std::max(std::abs(lo), std::abs(hi));
  return {0.5 * lo + 0.5 * hi, 0.5 * (hi - lo) + rounding};
}

/// The faces that a ray may pass, and what is certain about the two where it enters and leaves.
struct Ends {
  std::array<Face, 2> passed;  ///< certainly passed
  std::size_t passed_count = 0;
  /// Enclosure of all faces that the ray may pass; no side when their sides differ
  std::optional<Face> doubtful;

  RHORAY_INLINE void add(const Face& face, Passes how) {
    if (how == Passes::inside) {
      if (passed_count < 2) passed[passed_count++] = face;
    } else if (!doubtful) {
      doubtful = face;
    } else {
      if (doubtful->is_inside != face.is_inside) doubtful->is_inside.reset();
      doubtful->t = hull(doubtful->t, face.t);
      doubtful->value = hull(doubtful->value, face.value);
    }
  }
};

}  // namespace certified_tet

/// Where the ray crosses the isosurface in a tetrahedron.
///
/// A decision other than unknown is right for the ray, vertices, values and isovalue taken as exact
/// numbers. The decision none means that the ray changes side nowhere in the closed tetrahedron
/// between t_min and t_max. Unknown means that rounding could have changed the decision. Then the
/// surface is too close to where the ray enters or leaves, where it may pass through any of several
/// faces; or the position is known no better than to a thousandth of the cell's depth.
///
/// A ray that passes through the inside of one face goes on into the cell and leaves through
/// another. If it passes an edge closely, that other face may be in doubt. The choice does not
/// matter as long as all candidate faces are on one side where it passes. If no face is certainly
/// passed, the ray at most touches the cell. The decision is then none if all faces in doubt are on
/// one side there, and unknown otherwise.
template <class Real>
RHORAY_INLINE CertifiedTetCrossing certify_tet_crossing(const TetRay<Real>& ray, const TetPoints& points,
                                                        const TetValues& values, double isovalue) {
  using namespace certified_tet;
  constexpr CertifiedTetCrossing none{.decision = Decision::none}, unknown{};
  std::array<double, 4> f;
  int inside = 0;
  for (std::size_t i = 0; i < 4; ++i) f[i] = values[i] - isovalue, inside += is_inside(f[i]);
  if (inside == 0 || inside == 4) return none;
  // The rounding bounds below do not include underflow. Where the field crosses does not depend on
  // its unit.
  const double largest = std::max({std::abs(f[0]), std::abs(f[1]), std::abs(f[2]), std::abs(f[3])});
  if (largest < 0x1p-500)
    for (double& difference : f) difference *= 0x1p500;

  std::array<Vertex, 4> v;
  for (std::size_t i = 0; i < 4; ++i) {
    const SeenVertex<Real> seen = ray.shear.see(points[i]);
    const typename RayShearOf<Real>::Errors errors = ray.shear.errors(points[i], seen);
    v[i] = {static_cast<double>(seen.x), static_cast<double>(seen.y), seen.t, errors.x, errors.y, errors.t};
  }
  const auto is_before = [&](const Vertex& p) { return p.t + p.t_error < ray.ray.t_min; };
  const auto is_beyond = [&](const Vertex& p) { return p.t - p.t_error > ray.ray.t_max; };
  if (std::all_of(v.begin(), v.end(), is_before) || std::all_of(v.begin(), v.end(), is_beyond)) return none;

  // Each edge once, from the lower to the higher corner; around a face one of its three runs the
  // other way.
  const auto negated = [](Edge e) { return Edge{-e.value, e.error}; };
  const Edge e01 = edge(v[0], v[1]), e02 = edge(v[0], v[2]), e03 = edge(v[0], v[3]);
  const Edge e12 = edge(v[1], v[2]), e13 = edge(v[1], v[3]), e23 = edge(v[2], v[3]);
  struct Candidate {
    std::array<std::size_t, 3> corner;
    std::array<Edge, 3> opposite;  ///< the edge opposite each corner
  };
  const std::array<Candidate, 4> candidates{{{{1, 2, 3}, {e23, negated(e13), e12}},
                                             {{0, 2, 3}, {e23, negated(e03), e02}},
                                             {{0, 1, 3}, {e13, negated(e03), e01}},
                                             {{0, 1, 2}, {e12, negated(e02), e01}}}};
  Ends ends;
  for (const Candidate& candidate : candidates)
    if (const Passes how = passes(candidate.opposite); how != Passes::not_at_all)
      ends.add(cross(v, f, candidate.corner, candidate.opposite, how), how);
  if (ends.passed_count == 0 && (!ends.doubtful || ends.doubtful->is_inside)) return none;
  if (ends.passed_count == 0 || (ends.passed_count == 1 && !ends.doubtful)) return unknown;

  const Face &from = ends.passed[0], &to = ends.passed_count == 2 ? ends.passed[1] : *ends.doubtful;
  if (!from.is_inside || !to.is_inside) return unknown;
  if (*from.is_inside == *to.is_inside) return none;
  const Mean t = crossing_between(from, to);
  if (t.value + t.error < ray.ray.t_min || t.value - t.error > ray.ray.t_max) return none;
  if (!(t.value - t.error > ray.ray.t_min && t.value + t.error < ray.ray.t_max)) return unknown;
  const auto [nearest, farthest] = std::minmax({v[0].t, v[1].t, v[2].t, v[3].t});
  if (!(t.error <= 1e-3 * (farthest - nearest))) return unknown;
  return {Decision::crosses, t.value, t.error};
}

}  // namespace rhoray::render
