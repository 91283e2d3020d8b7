#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/kernels/intersection_timer.h"
#include "render/kernels/kernels.h"
#include "render/kernels/largest_value_search.h"

/// The kernels of grids, for every way in which samples can lie and stand (render/volumes/grid_volume.h). The sources
/// beside this header instantiate kernels_for, some views each.
namespace rhoray::render {

namespace {  // each source its own, so that the compiler sees that nothing else calls these

/// A point of the ray in a cell's own coordinates, [0, 1]^3. On the axis of the plane through which the ray comes in or
/// leaves it is exactly 0 or 1: both cells at a face then see the same point.
template <class Geometry>
RHORAY_INLINE Vec3 point_in_cell(const Geometry& geometry, const Ray& ray, const Index3& cell, double t, int axis,
                                 double at_axis) {
  Vec3 p;
  for (int a = 0; a < 3; ++a)
    p[a] =
        a == axis ? at_axis : std::clamp(geometry.in_cell(a, ray.origin[a] + t * ray.direction[a], cell[a]), 0.0, 1.0);
  return p;
}

template <class Geometry, class Planes>
RHORAY_INLINE Vec3 entry_point(const Geometry& geometry, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                               const CellVisit& visit) {
  const int axis = visit.axis_in;
  return point_in_cell(geometry, ray, visit.cell, visit.t_in, axis, axis >= 0 && planes.step(axis) < 0 ? 1 : 0);
}

template <class Geometry, class Planes>
RHORAY_INLINE Vec3 exit_point(const Geometry& geometry, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                              const CellVisit& visit) {
  const int axis = visit.axis_out;
  return point_in_cell(geometry, ray, visit.cell, visit.t_out, axis, axis >= 0 && planes.step(axis) < 0 ? 0 : 1);
}

struct PassedMacrocell {
  int level;
  CellVisit visit;
};

/// True when the last leaf cell that the ray passes through in a macrocell has data.
template <class View, class Planes>
bool leaves_through_data(const View& view, const Ray& ray, const PlaneTimesOf<Planes>& planes,
                         const PassedMacrocell& passed) {
  const WalkLattice lattice = view.lattice();
  bool has_data = false;
  auto enters = [](int, const CellVisit&) { return true; };
  auto leaf = [&](const CellVisit& visit) {
    if (!visit.has_no_length()) has_data = view.has_data(view.cell(visit.cell));
    return true;
  };
  const int below = passed.level - 1;
  walk_hierarchy(ray, planes, lattice, below, children(lattice, passed.visit.cell, lattice.cell_edge(below)),
                 passed.visit.t_in, passed.visit.t_out, enters, leaf);
  return has_data;
}

template <class View, bool timed>
Hit first_crossing(const View& view, const Question& question, const Ray& ray, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = view.lattice();
  const auto planes = view.plane_times(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, lattice.leaf_count);
  if (!segment) return hit;
  const double iso = question.isovalue;

  // The side on which the ray is; nothing while it has not met data since it started or crossed a region without.
  std::optional<bool> inside;
  // The macrocell that was passed over last, when nothing was looked into since.
  std::optional<PassedMacrocell> passed;
  // True where all values lie on the side on which the ray already is. On the other side the region is looked into:
  // rounding may have put the ray there where it passed an edge between cells, and the change of side must not be lost.
  const auto nothing_changes = [&](const Interval<double>& range) {
    std::optional<bool> side;
    if (range.lo >= iso)
      side = true;
    else if (range.hi < iso)
      side = false;
    if (!side || (inside && *inside != *side)) return false;
    inside = side;
    return true;
  };

  auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    const Interval<double> range = view.range(level, visit.cell);
    if (range.is_empty()) {
      inside.reset();
      return false;
    }
    if (!nothing_changes(range)) return true;
    passed = {level, visit};
    return false;
  };
  auto leaf = [&](const CellVisit& visit) {
    if (visit.has_no_length()) return true;
    ++counters.cells_visited;
    const TrilinearCell cell = view.cell(visit.cell);
    const std::optional<PassedMacrocell> before = std::exchange(passed, std::nullopt);
    if (!view.has_data(cell)) {
      inside.reset();
      return true;
    }
    if (nothing_changes({cell.smallest(), cell.largest()})) return true;

    const IntersectionTimer<timed> timer(counters);
    ++counters.cells_solved;
    const Vec3 p_in = entry_point(view.geometry(), ray, planes, visit);
    const Vec3 p_out = exit_point(view.geometry(), ray, planes, visit);
    const Cubic cubic = cell.along(p_in, p_out, iso);
    const bool starts_inside = is_inside(cubic.b[0]);
    // A macrocell's range says nothing of cells without data in it: the side that was taken from there may be no longer
    // known where the ray leaves it.
    if (inside && *inside != starts_inside && before && !leaves_through_data(view, ray, planes, *before))
      inside.reset();
    if (!inside) inside = starts_inside;
    const std::optional<double> s = first_change_of_side(cubic, *inside);
    if (!s) return true;  // the side at the exit is the side at the entry
    hit.t = visit.t_at(*s);
    hit.value = iso;
    hit.cell = view.cell_id(visit.cell);
    hit.gradient = view.geometry().gradient(cell.gradient((1 - *s) * p_in + *s * p_out), visit.cell);
    return false;
  };

  const int top = question.use_hierarchy ? view.level_count() : 0;
  walk_hierarchy(ray, planes, lattice, top, whole_level(lattice, lattice.cell_edge(top)), segment->t_in, segment->t_out,
                 enters, leaf);
  return hit;
}

/// The cell in which the ray is at t, up to rounding.
template <class Planes>
RHORAY_INLINE Index3 cell_at(const Ray& ray, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice, double t) {
  Index3 cell;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t count = lattice.leaf_count[a];
    const double at_planes = planes.planes().in_planes(a, ray.origin[a] + t * ray.direction[a], 0, count);
    cell[a] = static_cast<std::int64_t>(std::clamp(std::floor(at_planes), 0.0, static_cast<double>(count - 1)));
  }
  return cell;
}

/// When the ray came through the last face before t, or t_in where it has met none: the face rule sees no other points.
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

/// A value that the ray reaches near t, lowered by about its rounding; -infinity where there is no data. It is a guess
/// that saves work: at t the ray may already be in another cell, by rounding.
template <class View, class Planes>
double value_near(const View& view, const PlaneTimesOf<Planes>& planes, const WalkLattice& lattice, const Ray& ray,
                  double t) {
  const Index3 cell = cell_at(ray, planes, lattice, t);
  const TrilinearCell corners = view.cell(cell);
  if (!view.has_data(corners)) return -std::numeric_limits<double>::infinity();
  const double magnitude = std::max(std::abs(corners.smallest()), std::abs(corners.largest()));
  return corners.at(point_in_cell(view.geometry(), ray, cell, t, -1, 0)) - 1e-12 * magnitude;
}

template <class View, bool timed, MipMethod method>
Hit largest_value(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  const WalkLattice lattice = view.lattice();
  const auto planes = view.plane_times(ray);
  const std::optional<Segment> segment = clip_to_lattice(ray, planes, lattice.leaf_count);
  if (!segment) return {};
  KernelCounters& counters = scratch.counters;

  double lower_bound = -std::numeric_limits<double>::infinity();
  if (question.use_last_t) {
    const double middle = 0.5 * (segment->t_in + segment->t_out);
    double t = std::clamp(scratch.last_t.value_or(middle), segment->t_in, segment->t_out);
    if constexpr (method == MipMethod::face) t = last_face_before(ray, planes, lattice, t, segment->t_in);
    lower_bound = value_near(view, planes, lattice, ray, t);
  }

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
    const IntersectionTimer<timed> timer(counters);
    ++counters.cells_solved;
    const TrilinearCell cell = view.cell(entry.cell);
    // Measured from the cell's largest value, which is its bound: no sum is above zero, and a plateau is exactly zero.
    const CellVisit visit{entry.cell, entry.t_in, entry.t_out, entry.axis_in, entry.axis_out};
    const Cubic cubic = cell.along(entry_point(view.geometry(), ray, planes, visit),
                                   exit_point(view.geometry(), ray, planes, visit), entry.bound);
    CubicMaximum best{cubic.b[0], 0};
    if constexpr (method == MipMethod::exact)
      best = render::largest_value(cubic);
    else if (cubic.b[3] > cubic.b[0])
      best = {cubic.b[3], 1};
    offer(entry.bound + best.value, visit.t_at(best.s), view.cell_id(visit.cell));
  };
  const int top = question.use_hierarchy ? view.level_count() : 0;
  Hit hit = largest_value_search(ray, planes, lattice, top, lower_bound, scratch, bound, open_leaf);
  // A lower bound that rounding made too high drops everything, the answer too; it never gives another one.
  constexpr double no_bound = -std::numeric_limits<double>::infinity();
  if (hit.is_miss() && lower_bound > no_bound)
    hit = largest_value_search(ray, planes, lattice, top, no_bound, scratch, bound, open_leaf);
  if (!hit.is_miss()) scratch.last_t = hit.t;
  return hit;
}

template <class View, bool timed>
void first_crossing_kernel(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                           std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r)
    hits[r] = first_crossing<View, timed>(view, question, rays[r], scratch.counters);
}

template <class View, bool timed, MipMethod method>
void largest_value_kernel(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
                          std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r)
    hits[r] = largest_value<View, timed, method>(view, question, rays[r], scratch);
}

template <class View, bool timed>
Kernels choose(const View& view, MipMethod method) {
  return {.first_crossing = first_crossing_kernel<View, timed>,
          .largest_value = method == MipMethod::exact ? largest_value_kernel<View, timed, MipMethod::exact>
                                                      : largest_value_kernel<View, timed, MipMethod::face>,
          .queue_entries = largest_queue_size(view.lattice(), view.level_count())};
}

}  // namespace

template <class View>
Kernels kernels_for(const View& view, MipMethod method, bool timed) {
  return timed ? choose<View, true>(view, method) : choose<View, false>(view, method);
}

}  // namespace rhoray::render
