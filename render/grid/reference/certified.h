#pragma once

#include <array>

#include "render/cell/certified_crossing.h"
#include "render/grid/reference/exact.h"
#include "render/grid/reference/largest.h"
#include "render/grid/reference/passage.h"
#include "render/grid/reference/resumed.h"

/// The certified first crossing of a grid's isosurface. What one precision cannot decide, with its
/// rounding included, is decided in double precision; what that cannot decide is decided by exact
/// arithmetic.
namespace rhoray::render {

namespace {

/// Error bounds of a ray's walk through the lattice.
struct WalkRounding {
  /// A plane's time is (plane - origin) / direction in three operations: its relative error is
  /// below 2^-51.
  static constexpr double of_time = 0x1p-51;

  /// True when rounding may have exchanged the times.
  static bool may_be_exchanged(double a, double b) {
    return std::abs(a - b) <= 2 * of_time * std::max(std::abs(a), std::abs(b));
  }
};

/// True when the ray certainly does not meet the closed box of the lattice; false also where
/// rounding hides it.
template <class Planes>
bool certainly_misses(const Ray& ray, const PlaneTimesOf<Planes>& planes, const Index3& size) {
  double t_in = ray.t_min, t_out = ray.t_max;
  bool moves = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(ray.origin[axis]) || !std::isfinite(ray.direction[axis])) return true;
    if (planes.step(axis) == 0) {
      const double low = planes.planes().position(axis, 0), high = planes.planes().position(axis, size[axis]);
      if (!(ray.origin[axis] >= low && ray.origin[axis] <= high)) return true;
      continue;
    }
    moves = true;
    const bool forward = planes.step(axis) > 0;
    t_in = std::max(t_in, planes.at(axis, forward ? 0 : size[axis]));
    t_out = std::min(t_out, planes.at(axis, forward ? size[axis] : 0));
  }
  return !moves || (t_in > t_out && !WalkRounding::may_be_exchanged(t_in, t_out));
}

/// True when the ray passes close to a second plane where it enters or leaves a region, so close
/// that rounding may have put it on the wrong side of the edge between them.
template <class Planes>
bool passes_close_to_edge(const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice, std::int64_t edge,
                          const CellVisit& visit) {
  if (WalkRounding::may_be_exchanged(visit.t_in, visit.t_out)) return true;
  for (int axis = 0; axis < 3; ++axis) {
    if (planes.step(axis) == 0) continue;
    const std::int64_t low = visit.cell[axis] * edge, high = std::min(low + edge, lattice.leaf_count[axis]);
    const bool forward = planes.step(axis) > 0;
    if (axis != visit.axis_in && WalkRounding::may_be_exchanged(planes.at(axis, forward ? low : high), visit.t_in))
      return true;
    if (axis != visit.axis_out && WalkRounding::may_be_exchanged(planes.at(axis, forward ? high : low), visit.t_out))
      return true;
  }
  return false;
}

/// True when one of the neighbouring regions contains both sides or no data: then it matters which
/// of them the ray passes through.
template <class View>
bool sides_change_around(const View& view, double isovalue, int level, const Index3& cell) {
  const WalkLattice lattice = view.lattice();
  const Index3 end = whole_level(lattice, lattice.cell_edge(level)).end;
  for (std::int64_t k = std::max<std::int64_t>(0, cell.z - 1); k < std::min(end.z, cell.z + 2); ++k)
    for (std::int64_t j = std::max<std::int64_t>(0, cell.y - 1); j < std::min(end.y, cell.y + 2); ++j)
      for (std::int64_t i = std::max<std::int64_t>(0, cell.x - 1); i < std::min(end.x, cell.x + 2); ++i) {
        Interval<double> range;
        if (level > 0) {
          range = view.range(level, {i, j, k});
        } else if (const TrilinearCell corners = view.cell({i, j, k}); view.has_data(corners)) {
          range = {corners.smallest(), corners.largest()};
        }
        if (range.is_empty() || !side_of_all(range, isovalue)) return true;
      }
  return false;
}

/// Bound on the distance, in a cell's coordinates and on any axis, between the ray's computed point
/// at t and the exact one.
template <class Geometry>
double point_error(const Geometry& geometry, const Ray& ray, const Index3& cell, double t) {
  double error = 0;
  for (int a = 0; a < 3; ++a) {
    // The time's own error along the axis, two roundings of the position, and two of its coordinate
    // in the cell.
    const double reach = std::abs(ray.origin[a]) + std::abs(t) * std::abs(ray.direction[a]);
    error = std::max(error, geometry.direction_in_cell(a, reach, cell[a]));
  }
  return 4 * WalkRounding::of_time * error + 0x1p-52;
}

/// True when all cells that the ray may pass through at t have the field on the same side there:
/// whatever rounding exchanged, there is no change in them.
///
/// Planes that may be exchanged are passed at most 4 of_time |t| apart, which moves a point by no
/// more than its own error. So the ray's parts between them lie within twice that of the point, in
/// each cell's own coordinates.
template <class View, class Planes>
bool stays_on_one_side_at(const View& view, double isovalue, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                          double t) {
  const auto& geometry = view.geometry();
  const Index3 count = view.lattice().leaf_count, at = cell_at(ray, planes, view.lattice(), t);
  const double reach = 8 * point_error(geometry, ray, at, t);
  Index3 first, last;
  for (int a = 0; a < 3; ++a) {
    const double p = geometry.in_cell(a, ray.origin[a] + t * ray.direction[a], at[a]);
    first[a] = p <= reach ? std::max<std::int64_t>(0, at[a] - 1) : at[a];
    last[a] = p >= 1 - reach ? std::min(count[a] - 1, at[a] + 1) : at[a];
  }
  std::optional<bool> side;
  for (std::int64_t k = first.z; k <= last.z; ++k)
    for (std::int64_t j = first.y; j <= last.y; ++j)
      for (std::int64_t i = first.x; i <= last.x; ++i) {
        const Index3 cell{i, j, k};
        const TrilinearCell corners = view.cell(cell);
        if (!view.has_data(corners)) continue;
        const std::optional<bool> here = certain_side<double>(corners, point_in_cell(geometry, ray, cell, t, -1, 0),
                                                              8 * point_error(geometry, ray, cell, t), isovalue);
        if (!here || (side && *side != *here)) return false;
        side = here;
      }
  return true;
}

struct CertifiedHit {
  Hit hit;
  bool is_certain = true;
};

/// @param from  where to begin
template <class Real, class View>
CertifiedHit certified_crossing(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                                const ResumedAt& from = {}) {
  CertifiedHit answer;
  const WalkLattice lattice = view.lattice();
  const auto planes = view.plane_times(ray);
  std::optional<Segment> segment = clip_to_lattice(ray, planes, lattice.leaf_count);
  if (!segment) {
    answer.is_certain = certainly_misses(ray, planes, lattice.leaf_count);
    return answer;
  }
  segment->t_in = std::clamp(from.t, segment->t_in, segment->t_out);
  const double iso = query.isovalue;

  SideOnRay side(view, ray);
  if (from.side != StartSide::unknown) side.set(from.side == StartSide::inside);
  const auto see = [&](int level, const CellVisit& visit) {
    answer.is_certain = !passes_close_to_edge(planes, lattice, lattice.cell_edge(level), visit) ||
                        (stays_on_one_side_at(view, iso, ray, planes, visit.t_in) &&
                         stays_on_one_side_at(view, iso, ray, planes, visit.t_out)) ||
                        !sides_change_around(view, iso, level, visit.cell);
    return answer.is_certain;
  };
  const auto look = [&](const TrilinearCell& cell, const CellVisit& visit, const auto& before) {
    if (before && !side.leaves_through_data(*before, planes)) side.forget();
    const Vec3 in = entry_point(view.geometry(), ray, planes, visit);
    const Vec3 out = exit_point(view.geometry(), ray, planes, visit);
    const double error =
        point_error(view.geometry(), ray, visit.cell, std::max(std::abs(visit.t_in), std::abs(visit.t_out)));
    if (!side.inside()) {
      const std::optional<bool> starts_inside = certain_side<Real>(cell, in, error, iso);
      if (!starts_inside) return answer.is_certain = false;
      side.set(*starts_inside);
    }
    const CertifiedCrossing found = certify_crossing<Real>(cell, in, out, error, iso, *side.inside());
    if (found.decision == Decision::none) return true;
    if (found.decision == Decision::unknown || !is_placed_well<Real>(found, in, out, error))
      return answer.is_certain = false;
    Hit& hit = answer.hit;
    complete(hit, view, visit, cell, in, out, found);
    hit.value = iso;
    hit.error = found.s_error * (visit.t_out - visit.t_in) + 4 * WalkRounding::of_time * std::abs(hit.t);
    // A ray's own ends are exact: a hit that may lie beyond them is not certain.
    answer.is_certain = hit.t - hit.error >= ray.t_min && hit.t + hit.error <= ray.t_max;
    return false;
  };
  walk_sides(view, query, ray, planes, *segment, counters, side, see, look);
  return answer;
}

/// Decides what single precision could not: in double precision, or else by exact arithmetic.
/// @param from  where to begin; if that leaves a doubt, the whole ray is traced
template <class View>
Hit certified_first_crossing_redone(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch,
                                    const ResumedAt& from = {}) {
  ++scratch.counters.rays_redone;
  if (from.t > ray.t_min) {
    const CertifiedHit answer = certified_crossing<double>(view, query, ray, scratch.counters, from);
    if (answer.is_certain) return answer.hit;
  }
  const CertifiedHit answer = certified_crossing<double>(view, query, ray, scratch.counters);
  return answer.is_certain ? answer.hit : exact_first_hit(view, query, ray, scratch);
}

template <class View>
Hit certified_first_crossing(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const CertifiedHit answer = certified_crossing<float>(view, query, ray, scratch.counters);
  return answer.is_certain ? answer.hit : certified_first_crossing_redone(view, query, ray, scratch);
}

/// The largest value with an error bound: nothing on the ray lies above value + error, and the
/// largest value is not below value - error. The t of a plateau, or of one of several nearly equal
/// maxima, is not certified.
template <class View>
Hit certified_largest_value(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  const auto planes = view.plane_times(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, view.lattice().leaf_count);
  if (!segment)
    return certainly_misses(ray, planes, view.lattice().leaf_count) ? Hit{}
                                                                    : exact_largest_hit(view, query, ray, scratch);
  double largest_possible = -std::numeric_limits<double>::infinity(), worst_place = 0;
  const auto in_cell = [&](const TrilinearCell& cell, const CellVisit& visit, const Vec3& in, const Vec3& out, double) {
    const double place =
        point_error(view.geometry(), ray, visit.cell, std::max(std::abs(visit.t_in), std::abs(visit.t_out)));
    worst_place = std::max(worst_place, place);
    const CertifiedMaximum best = certify_largest_value<double>(cell, in, out, place);
    largest_possible = std::max(largest_possible, best.value + best.value_error);
    return CubicMaximum{best.value, best.s};
  };
  Hit hit = search_largest(view, query, ray, planes, -std::numeric_limits<double>::infinity(), scratch, in_cell);
  // Parts of length zero, by rounding.
  if (hit.is_miss()) return exact_largest_hit(view, query, ray, scratch);
  // Rounding may have left out a cell that the ray only grazes. Such a cell shares an edge with one
  // that was not left out. Its values differ from those on the edge by no more than the field can
  // change over the rounding.
  hit.error = std::max(largest_possible - hit.value, 0x1p-50 * std::abs(hit.value)) +
              3.1 * worst_place * (query.field_range.hi - query.field_range.lo);
  return hit;
}

}  // namespace

}  // namespace rhoray::render
