#pragma once

#include <algorithm>
#include <cmath>

#include "render/grid/reference/passage.h"
#include "render/query/largest_value_search.h"

/// The largest value on a ray through a grid: on faces (paper, section 4.3), or by the cubics'
/// critical points.
namespace rhoray::render {

namespace {

/// The t at which the ray passed the last face before t, or t_in if it has passed none. The face
/// rule considers no other points.
template <class Planes>
RHORAY_INLINE double last_face_before(const Ray& ray, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice,
                                      double t, double t_in) {
  const Index3 cell = cell_at(ray, planes, lattice, t);
  double last = t_in;
  for (int a = 0; a < 3; ++a) {
    if (planes.step(a) == 0) continue;
    const double entered = planes.at(a, planes.step(a) > 0 ? cell[a] : cell[a] + 1);
    if (entered <= t && entered > last) last = entered;
  }
  return last;
}

/// A value that the ray reaches near t, lowered by about its rounding; -infinity where there is no
/// data. It is a guess that saves work: at t the ray may already be in another cell, by rounding.
template <class View, class Planes>
double value_near(const View& view, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice, const Ray& ray,
                  double t, double rounding) {
  const Index3 cell = cell_at(ray, planes, lattice, t);
  const TrilinearCell corners = view.cell(cell);
  if (!view.has_data(corners)) return -std::numeric_limits<double>::infinity();
  const double magnitude = std::max(std::abs(corners.smallest()), std::abs(corners.largest()));
  return corners.at(point_in_cell(view.geometry(), ray, cell, t, -1, 0)) - rounding * magnitude;
}

/// The search in a grid.
/// @param in_cell      (cell, visit, in, out, the cell's largest value): returns the largest value
///                     on the path and its s
/// @param lower_bound  a value that the ray reaches, or a little less
template <class View, class Planes, class InCell>
Hit search_largest(const View& view, const RayQuery& query, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                   double lower_bound, KernelScratch& scratch, InCell&& in_cell) {
  KernelCounters& counters = scratch.counters;
  const auto bound = [&](int level, const Index3& at) {
    if (level > 0) {
      ++counters.macrocells_visited;
      return view.range(level, at).hi;
    }
    ++counters.cells_visited;
    const TrilinearCell cell = view.cell(at);
    return view.has_data(cell) ? cell.largest() : -std::numeric_limits<double>::infinity();
  };
  const auto open_leaf = [&](const MaximumQueue::Entry& entry, const auto& offer) {
    const IntersectionTimer timer(query, counters);
    ++counters.cells_solved;
    const CellVisit visit{entry.cell, entry.t_in, entry.t_out, entry.axis_in, entry.axis_out};
    const CubicMaximum best = in_cell(view.cell(entry.cell), visit, entry_point(view.geometry(), ray, planes, visit),
                                      exit_point(view.geometry(), ray, planes, visit), entry.bound);
    offer(best.value, visit.t_at(best.s), view.cell_id(visit.cell));
  };
  const int top = query.use_hierarchy ? view.level_count() : 0;
  Hit hit = largest_value_search(ray, planes, view.lattice(), top, lower_bound, scratch, bound, open_leaf);
  // A lower bound that rounding made too high drops everything, the answer included; it never leads
  // to a different answer.
  constexpr double no_bound = -std::numeric_limits<double>::infinity();
  if (hit.is_miss() && lower_bound > no_bound)
    hit = largest_value_search(ray, planes, view.lattice(), top, no_bound, scratch, bound, open_leaf);
  return hit;
}

/// The value at a point of a cell's face across an axis. It is computed from the face's four
/// corners alone, so that both cells at the face get the same bits. It is computed relative to the
/// largest of the four: no sum is above it, and a plateau has exactly its own value.
/// @param p  exactly 0 or 1 on the axis
RHORAY_INLINE double value_on_face(const TrilinearCell& cell, const Vec3& p, int axis) {
  const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  double f[4];
  for (int c = 0; c < 4; ++c)
    f[c] = cell.corner[static_cast<std::size_t>((p[axis] == 1) << axis | (c & 1) << first | (c >> 1) << second)];
  const double largest = std::max({f[0], f[1], f[2], f[3]});
  for (double& value : f) value -= largest;
  const double low = TrilinearCell::between(f[0], f[1], p[first]);
  const double high = TrilinearCell::between(f[2], f[3], p[first]);
  return largest + TrilinearCell::between(low, high, p[second]);
}

/// The largest value on the faces only, or of the whole cubic. It is computed relative to the
/// cell's largest value: no sum is above zero, and a plateau is exactly zero. Where the ray passes
/// a face the value is the face's, and the answer is no less.
/// @param bound  the cell's largest value
template <class Real>
CubicMaximum largest_in_cell(const TrilinearCell& cell, const CellVisit& visit, const Vec3& in, const Vec3& out,
                             double bound, bool on_faces) {
  const Differences<Real> below = minus<Real>(cell, bound);
  const CubicOf<Real> cubic = below.cell.along(Imath::Vec3<Real>(in), Imath::Vec3<Real>(out));
  CubicMaximumOf<Real> on_cubic{cubic.b[0], 0};
  if (!on_faces)
    on_cubic = largest_value(cubic);
  else if (cubic.b[3] > cubic.b[0])
    on_cubic = {cubic.b[3], 1};
  const auto above = [&](Real value) { return bound + below.unit * static_cast<double>(value); };
  const double at_in = visit.axis_in >= 0 ? value_on_face(cell, in, visit.axis_in) : above(cubic.b[0]);
  const double at_out = visit.axis_out >= 0 ? value_on_face(cell, out, visit.axis_out) : above(cubic.b[3]);
  const double s = static_cast<double>(on_cubic.s);
  CubicMaximum best{s == 0 ? at_in : s == 1 ? at_out : above(on_cubic.value), s};
  if (at_in > best.value) best = {at_in, 0};
  if (at_out > best.value) best = {at_out, 1};
  return best;
}

template <class View>
Hit largest_value_on_ray(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const auto planes = view.plane_times(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, view.lattice().leaf_count);
  if (!segment) return {};
  const bool on_faces = query.method.algorithm == Method::Algorithm::paper;
  const bool in_single = query.method.precision == Method::Precision::float32;

  double lower_bound = -std::numeric_limits<double>::infinity();
  if (query.use_last_t) {
    const double middle = 0.5 * (segment->t_in + segment->t_out);
    double t = std::clamp(scratch.last_t.value_or(middle), segment->t_in, segment->t_out);
    if (on_faces) t = last_face_before(ray, planes, view.lattice(), t, segment->t_in);
    lower_bound = value_near(view, planes, view.lattice(), ray, t, in_single ? 1e-5 : 1e-12);
  }
  const auto in_cell = [&](const TrilinearCell& cell, const CellVisit& visit, const Vec3& in, const Vec3& out,
                           double bound) {
    return in_single ? largest_in_cell<float>(cell, visit, in, out, bound, on_faces)
                     : largest_in_cell<double>(cell, visit, in, out, bound, on_faces);
  };
  const Hit hit = search_largest(view, query, ray, planes, lower_bound, scratch, in_cell);
  if (!hit.is_miss()) scratch.last_t = hit.t;
  return hit;
}

}  // namespace

}  // namespace rhoray::render
